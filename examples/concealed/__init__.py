"""An independent rig that makes recordings with something left out of the model, seals the truth.

And scores the answers.

Nothing here imports `coast_cli`: the physics is written again from the published equations, finer and in other
forms than the library fits, so that a good score cannot be the library agreeing with itself. See README.md for the
levels and the commands.
"""
