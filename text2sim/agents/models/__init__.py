"""Language models: requests, endpoints, costs, and parsing of replies.

`litellm_client` is the only module that imports litellm.
"""
