"""Names of cases, the same in every process that collects them."""

from providers.base import Fails, Provider, Says


def case_name(value: object) -> str:
    """What a provider, a refusal, a reply or a word is called in the name of a test."""
    match value:
        case type() if issubclass(value, Provider):
            return value.__name__
        case Fails():
            return f"{value.status} {value.message}"[:60]
        case Says():
            return f"{value.finish} {value.text}"[:60]
        case _:
            return str(value)
