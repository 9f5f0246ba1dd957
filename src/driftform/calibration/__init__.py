"""From filmed flights to factors on the model: tracks, camera, fit, intervals, and the next experiment."""
