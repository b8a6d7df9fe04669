"""Client for every provider that litellm supports, and every OpenAI-compatible server.

litellm is configured to make a single request and nothing else: no telemetry, no retries, no files, no `.env`, no
download of prices. Keys come from the environment and are used for the request alone.
"""

import base64
import logging
import math
import os
import random
import time
from collections.abc import Callable
from functools import lru_cache
from queue import Empty, SimpleQueue
from threading import Lock, Thread
from typing import Any

from text2sim.agents.models.exchange import Image, Message, ModelError, ModelName, ModelRequest, Reply, StoppedError
from text2sim.agents.models.provider_errors import model_error, status_of, wait_asked
from text2sim.spec_schema.errors import MachineError

TIMEOUT = 600.0
"""Longest time of one try [s]."""
MAX_TRIES = 6
LONGEST_WAIT = 120.0
"""Longest pause that a provider may ask for [s]."""
OWN_KEY = "TEXT2SIM_API_KEY"
"""Variable with the key for servers given by address. A provider's key is never sent to another address."""
_TICK = 0.1
_import = Lock()


class LiteLLMEndpoint:
    """A model that is called through litellm.

    Args:
        name: The model.
        timeout: Longest time of one try [s].
        tries: Number of tries before giving up.
        first_wait: Pause before the second try [s] if the provider names none; doubles with each try.

    Raises:
        ModelError: If the provider is unknown, or its key is not in the environment.
        MachineError: If litellm is not installed.
    """

    cacheable = True

    def __init__(
        self, name: ModelName, *, timeout: float = TIMEOUT, tries: int = MAX_TRIES, first_wait: float = 2.0
    ) -> None:
        self._url, self._timeout, self._tries, self._first_wait = name.url, timeout, tries, first_wait
        library = _library()
        self._model = f"openai/{name.model}" if name.url else name.model
        self.name = f"{name.model}@{name.url}" if name.url else name.model
        self._who = f"{name.model} at {name.url}" if name.url else name.model
        if name.url is None:
            _check_access(library, name.model)
        known: bool = library.supports_vision(model=self._model)
        self.vision = known if name.vision is None else name.vision
        held: bool = library.supports_response_schema(model=self._model)
        self._schema = held if name.schema is None else name.schema

    def complete(self, request: ModelRequest, stop: Callable[[], bool]) -> Reply:
        """Call the model, with retries after transient errors; see `Endpoint.complete`.

        Raises:
            ModelError: If the call failed, also after all retries.
        """
        schema = self._schema and request.schema is not None
        start, tried = time.monotonic(), 0
        while True:
            tried += 1
            try:
                response = self._try_once(self._arguments(request, schema), stop)
                return self._reply(request, response, time.monotonic() - start)
            except ModelError:
                raise
            except Exception as error:
                if schema and status_of(error) == 400 and _is_about_schema(error):
                    schema, tried = False, tried - 1  # the model supports schemas, but not all keywords of this one
                    continue
                failure = model_error(self._who, error)
                if not failure.retryable or tried >= self._tries:
                    tries = f" (after {tried} tries)" if tried > 1 else ""
                    raise ModelError(f"{failure}{tries}", retryable=failure.retryable) from None
                asked = wait_asked(error)
            self._pause(tried, asked, failure, stop)

    def _arguments(self, request: ModelRequest, schema: bool) -> dict[str, Any]:
        arguments: dict[str, Any] = {
            "model": self._model,
            "messages": [self._message(message) for message in request.messages],
            "max_tokens": request.max_tokens,
            "timeout": self._timeout,
            "num_retries": 0,
            "max_retries": 0,
            "drop_params": True,
        }
        if request.temperature is not None:
            arguments["temperature"] = request.temperature
        if schema:
            form = {"name": request.role.replace("-", "_"), "schema": request.schema, "strict": False}
            arguments["response_format"] = {"type": "json_schema", "json_schema": form}
        if self._url is not None:
            # A local server needs no key, but the client insists on one.
            arguments |= {"api_base": self._url, "api_key": os.environ.get(OWN_KEY) or "none"}
        return arguments

    def _message(self, message: Message) -> dict[str, Any]:
        if not message.images:
            return {"role": message.role, "content": message.text}
        if not self.vision:
            names = ", ".join(f"`{image.name}`" for image in message.images)
            left = f"[Pictures are left out, since you see none: {names}]"
            return {"role": message.role, "content": f"{message.text}\n\n{left}"}
        parts: list[dict[str, Any]] = [{"type": "text", "text": message.text}]
        for image in message.images:
            parts.append({"type": "text", "text": f"Picture `{image.name}`:"})
            parts.append({"type": "image_url", "image_url": {"url": _data_url(image)}})
        return {"role": message.role, "content": parts}

    def _try_once(self, arguments: dict[str, Any], stop: Callable[[], bool]) -> Any:
        """One try, in its own thread, so that a slow or trickling server cannot block the loop."""
        library = _library()
        done: SimpleQueue[tuple[Any, Exception | None]] = SimpleQueue()

        def work() -> None:
            try:
                done.put((library.completion(**arguments), None))
            except Exception as error:  # re-raised in the waiting thread
                done.put((None, error))

        deadline = time.monotonic() + self._timeout
        Thread(target=work, name="model call", daemon=True).start()
        while True:
            try:
                response, error = done.get(timeout=_TICK)
            except Empty:
                if stop():
                    raise StoppedError(f"the call of {self._who} was stopped") from None
                if time.monotonic() > deadline:
                    raise TimeoutError(f"no reply in {self._timeout:g} s") from None
                continue
            if error is not None:
                raise error
            return response

    def _reply(self, request: ModelRequest, response: Any, seconds: float) -> Reply:
        try:
            choice = response.choices[0]
            text = choice.message.content or ""
            reason = choice.finish_reason
        except (AttributeError, IndexError, TypeError):
            raise ConnectionError("the answer is not a chat completion") from None
        if not isinstance(text, str):
            raise ConnectionError("the answer has no text")
        usage = getattr(response, "usage", None)
        sent, came = getattr(usage, "prompt_tokens", None), getattr(usage, "completion_tokens", None)
        estimated = False
        if not isinstance(sent, int) or not isinstance(came, int) or sent <= 0 or came < 0:
            estimated = True
            messages = [self._message(message) for message in request.messages]
            sent = _library().token_counter(model=self._model, messages=messages)
            came = _library().token_counter(model=self._model, text=text)
        cost = None if self._url is not None or estimated else _cost(response, self._model)
        return Reply(text, sent, came, cost, seconds, self.name, estimated=estimated, truncated=reason == "length")

    def _pause(self, tried: int, asked: float | None, failure: ModelError, stop: Callable[[], bool]) -> None:
        wait = self._first_wait * 2 ** (tried - 1) * random.uniform(0.75, 1.25)
        if asked is not None:
            if asked > LONGEST_WAIT:
                raise ModelError(f"{failure}; it asks to wait {asked:.0f} s", retryable=True)
            wait = asked + random.uniform(0, 0.1 * self._first_wait)
        end = time.monotonic() + min(wait, LONGEST_WAIT)
        while (left := end - time.monotonic()) > 0:
            if stop():
                raise StoppedError(f"stopped while waiting for {self._who}")
            time.sleep(min(left, _TICK))


@lru_cache(maxsize=1)
def _imported() -> Any:
    # litellm reads these at import: they select the packaged prices, and disable `.env`.
    os.environ["LITELLM_LOCAL_MODEL_COST_MAP"] = "True"
    os.environ["LITELLM_MODE"] = "PRODUCTION"
    try:
        import litellm
    except ImportError:
        raise MachineError("litellm is not installed; pip install 'text2sim[agents]'") from None
    library: Any = litellm
    library.telemetry = False
    library.suppress_debug_info = True
    library.drop_params = True
    library.turn_off_message_logging = True
    library.cache = None
    library.disable_hf_tokenizer_download = True  # it would download one to count tokens
    for callbacks in ("callbacks", "input_callback", "success_callback", "failure_callback", "service_callback"):
        setattr(library, callbacks, [])
    for name in ("LiteLLM", "LiteLLM Router", "LiteLLM Proxy"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    return library


def _library() -> Any:
    with _import:
        return _imported()


def _check_access(library: Any, model: str) -> None:
    try:
        library.get_llm_provider(model)
    except Exception:
        raise ModelError(f"`{model}`: there is no provider `{model.split('/')[0]}`; see docs/models.md") from None
    missing = library.validate_environment(model).get("missing_keys") or []
    if missing:
        raise ModelError(f"{model}: set {' and '.join(missing)} in the environment")


def _is_about_schema(error: Exception) -> bool:
    text = str(error).lower()
    return "response_format" in text or "json_schema" in text or "schema" in text


def _cost(response: Any, model: str) -> float | None:
    """Cost [US$]; None if litellm does not know the model's price."""
    try:
        cost = float(_library().completion_cost(completion_response=response, model=model))
    except Exception:  # litellm documents no exception type here
        return None
    return cost if math.isfinite(cost) and cost >= 0 else None


def _data_url(image: Image) -> str:
    return f"data:{image.media_type};base64,{base64.b64encode(image.data).decode('ascii')}"
