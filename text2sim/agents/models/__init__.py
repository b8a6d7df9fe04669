"""Language models: what is asked, whom, what it cost, and how a reply becomes data.

`litellm_client` is the only module that imports litellm.
"""
