"""Links with fewer coordinates: their ends and the lowest modes between them (Craig & Bampton 1968).

reduction.py finds a link's modes from its elements, layout.py says where their numbers are kept, link.py,
plane.py and space.py compute with them.
"""
