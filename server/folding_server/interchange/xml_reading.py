"""XML from elsewhere: no entities, no documents beside it."""

import re
from xml.etree.ElementTree import Element, ParseError

from folding_server.errors import ProgramError


def xml_root(text: str, kind: str) -> Element:
    """The root of an XML text; ProgramError if it is not XML or declares entities. ``kind`` names the file."""
    from defusedxml import DefusedXmlException
    from defusedxml.ElementTree import fromstring

    try:
        root: Element = fromstring(without_declaration(text), forbid_dtd=False)
    except ParseError as error:
        line, column = error.position
        raise ProgramError(
            f"The {kind} is not XML (line {line}, column {column + 1}); check the file or save it again."
        ) from None
    except (DefusedXmlException, ValueError, LookupError):
        raise ProgramError(
            f"The {kind} declares entities or names other documents, which are not read; save it again without them."
        ) from None
    return root


def without_declaration(text: str) -> str:
    """XML without its first line on versions and encodings: the text is decoded already."""
    return re.sub(r"^\s*<\?xml[^>]*\?>", "", text, count=1)
