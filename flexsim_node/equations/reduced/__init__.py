"""Links with fewer coordinates: their ends and the lowest modes between them (Craig & Bampton 1968).

model/reduced finds a link's modes from its elements and says where their numbers are kept; these files
compute with them.
"""
