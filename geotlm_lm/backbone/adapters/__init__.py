"""Released encoders: names in their files, preparation of pixels, and the tokens they return."""
