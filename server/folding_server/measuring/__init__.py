"""What evaluation asks of a state: its mesh, whether its crease pattern compiles, and what constrains its layers."""
