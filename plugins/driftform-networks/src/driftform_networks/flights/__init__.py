"""Bodies that fly through pipes and fittings, and the routing tables that their flights give."""
