"""A stream of frames -> motion events: the idle gel learnt, a sliding window, the model's reading.

Knows neither how a stream is opened on the command line nor how events are shown.
"""
