"""placeholder"""
def evaluate(): pass
