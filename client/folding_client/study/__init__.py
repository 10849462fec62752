"""Which of two reconstructions people find closer to the photos: a page that asks them, and the scores of their answers."""
