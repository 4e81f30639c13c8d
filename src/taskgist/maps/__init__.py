"""Maps: where an agent sees and reaches, cell by cell, and where things could be placed."""
