"""Instructions in words: each move named by what it aligns, in several languages, and the English read back."""
