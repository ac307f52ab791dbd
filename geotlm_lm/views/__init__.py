"""What the model saw, as pictures: uint8 RGB arrays, drawn with numpy and OpenCV only.

Knows neither how the geometry was made nor where the pictures are shown.
"""
