"""SVG to PNG."""


def rasterise(svg: str, size: int | None = None) -> bytes:
    """The picture as PNG bytes, at its own size or scaled to ``size`` pixels wide."""
    import cairosvg  # type: ignore[import-untyped]

    return bytes(cairosvg.svg2png(bytestring=svg.encode("utf-8"), output_width=size))
