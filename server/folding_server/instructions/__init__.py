"""Instructions to fold by: the moves of a program, their drawings in the Yoshizawa-Randlett convention, sheets of them."""
