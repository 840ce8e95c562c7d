"""Cost and saving of each modelling assumption for this finger in this scene.

solves.py solves each model once; assumptions.py pairs them; comparison.py holds two answers against
each other at equal motion and at equal force; advice.py makes a sentence of the numbers; record.py
is what is written.
"""
