# The reference uses GPL parts of CGAL (the AABB tree), so it is a library of its own.
