"""Whether a mesh is one folded square sheet: pieces, layers, stretch, flat-foldability, crossings."""
