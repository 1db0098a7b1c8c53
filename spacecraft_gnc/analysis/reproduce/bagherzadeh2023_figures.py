def figures(*f): return iter(())
