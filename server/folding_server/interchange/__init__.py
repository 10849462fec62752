"""Papers and programs as files: FOLD 1.2, crease-pattern SVG, ORIPA, OBJ and program JSON."""
