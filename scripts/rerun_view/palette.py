"""The colours that tell series apart, also for colour-blind eyes (Okabe and Ito)."""

SERIES = [
    (86, 180, 233), (230, 159, 0), (0, 158, 115), (204, 121, 167),
    (240, 228, 66), (0, 114, 178), (213, 94, 0), (160, 160, 160),
]  # fmt: skip
