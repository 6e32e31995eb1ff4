"""What is watched while a learner learns, so that the run may do something once it is met."""
