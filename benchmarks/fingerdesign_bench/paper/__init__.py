"""Every figure of Maeno et al. 2000 remade, and its claims held against them."""
