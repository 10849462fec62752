"""What providers write in their errors, as far as it decides what to do next.

The words are those of the errors that providers document, and of the servers for models of one's own (vLLM, llama.cpp,
Ollama). Each function reads an error's whole text, message and body.
"""

import re

_FLAGS = re.IGNORECASE | re.DOTALL
_NUMBER_WORDS = {"one": 1, "a single": 1, "single": 1}

_SPENT = re.compile(
    r"insufficient_quota|credit balance|insufficient.(credits|balance|funds)|out of credits|add (more )?credits"
    r"|billing_hard_limit|included credits|payment required|perday",
    _FLAGS,
)
_QUOTA = re.compile(r"exceeded your (current|monthly)[^.]*quota|quota exceeded|resource_exhausted", _FLAGS)
_FILTERED = re.compile(
    r"content.?(filter|policy|management)|safety system|usage polic|flagged|moderation|prohibited.content"
    r"|responsibleai",
    _FLAGS,
)
_TOO_LONG = re.compile(
    r"context.?(length|window|size|limit)|(prompt|input|request|conversation)[^.]{0,40} too (long|large)"
    r"|too many (input |prompt )?tokens|(token count|number of tokens)[^.]{0,80}exceed"
    r"|maximum (input|prompt)|longest (input|prompt)|payload too large|reduce the length",
    _FLAGS,
)
_CONTEXT = re.compile(r"context (?:length|window|size|limit)[^.\d]{0,40}?(\d{3,})", _FLAGS)
_REPLY = re.compile(
    r"(?:max_(?:completion_|output_|new_)?tokens|maxOutputTokens|(?:output|completion) tokens)[^.]*?"
    r"(?:at most|up to|less than or equal to|no more than|maximum(?: value)?(?: of| is)?|limit(?: of| is)?|<=|>)"
    r"\D{0,3}(\d{3,})",
    _FLAGS,
)
_REPLY_SUPPORTED = re.compile(r"(?:at most|up to|maximum of) (\d{3,}) (?:output|completion) tokens", _FLAGS)
_STREAM = re.compile(
    r"(only|must|required?|needs?|enable|without|non)\b[^.]{0,40}stream|stream\w*[^.]{0,40}\b(only|required)",
    _FLAGS,
)
_TOOLS = re.compile(
    r"(tools?|tool.use|tool.choice|function.call\w*)\b[^.]{0,40}(not supported|unsupported|requires?\b)"
    r"|support[^.]{0,20} (tool|function.call)",
    _FLAGS,
)
_PICTURE = re.compile(r"image|vision|multi.?modal", _FLAGS)
_PICTURE_ITSELF = re.compile(r"bytes|\bmi?b\b|pixel|dimension|resolution|decode|corrupt|base64", _FLAGS)
_MOST_PICTURES = re.compile(
    r"(?:at most|up to|max(?:imum)?(?: number)?(?: of| is)?|only(?: supports?)?|limit(?: of| is)?|>)\s*"
    r"(\d{1,3}|one|a single|single)\b",
    _FLAGS,
)
_SEVERAL = re.compile(r"too many|multiple|(single|one) image|images? (per|in)\b", _FLAGS)
_PACKAGE = re.compile(r"no module named|pip install", _FLAGS)
_NOT_TAKEN = r"(unsupported|not support|n't support|unknown|unrecogni[sz]ed|unexpected|extra|not permitted|not allowed|invalid)"


def says_quota_is_spent(words: str) -> bool:
    """The quota or the credit is spent, and a minute will not fill it again."""
    return _SPENT.search(words) is not None


def says_quota(words: str) -> bool:
    """Some quota is exceeded: spent, or a limit of requests in a minute, which Gemini calls so too."""
    return _QUOTA.search(words) is not None


def says_filtered(words: str) -> bool:
    """A content filter refused."""
    return _FILTERED.search(words) is not None


def says_too_long(words: str) -> bool:
    """The conversation is longer than the model's context."""
    return _TOO_LONG.search(words) is not None


def context_named(words: str) -> int | None:
    """The tokens of context that an error names."""
    return _number(_CONTEXT.search(words))


def longest_reply_named(words: str) -> int | None:
    """The most tokens of a reply that an error names."""
    return _number(_REPLY_SUPPORTED.search(words) or _REPLY.search(words))


def says_streaming_only(words: str) -> bool:
    """The model only streams."""
    return _STREAM.search(words) is not None


def says_no_tools(words: str) -> bool:
    """The model, or its server as it is set up, takes no tools."""
    return _TOOLS.search(words) is not None


def says_pictures(words: str) -> bool:
    """Pictures are refused for being pictures, or for being so many; not for what they are."""
    return _PICTURE.search(words) is not None and _PICTURE_ITSELF.search(words) is None


def most_pictures_named(words: str) -> int | None:
    """How many pictures a request may hold, if an error says that there are too many."""
    if found := _MOST_PICTURES.search(words):
        text = found.group(1).lower()
        return _NUMBER_WORDS.get(text) or int(text)
    return 1 if _SEVERAL.search(words) else None


def says_package_is_missing(words: str) -> bool:
    """litellm lacks a package that it needs to reach the provider."""
    return _PACKAGE.search(words) is not None


def says_not_taken(parameter: str, words: str) -> bool:
    """A parameter of the request is not known or not supported."""
    named = rf"\b{parameter}\b"
    return re.search(rf"{_NOT_TAKEN}.{{0,60}}{named}|{named}.{{0,60}}{_NOT_TAKEN}", words, _FLAGS) is not None


def _number(found: re.Match[str] | None) -> int | None:
    return int(found.group(1)) if found else None
