"""What a reconstruction is measured against: models that need no vision-language model, and look at no proposal."""
