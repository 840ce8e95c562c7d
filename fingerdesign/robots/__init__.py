"""The finger in a robot's world: descriptions for simulators, the contact inside MuJoCo."""
