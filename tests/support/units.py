"""A functional mock-up unit in fmpy, by the names of its variables."""

import pytest

WITHOUT = "pip install fmpy brings it"


class Running:
    """A unit, unpacked into a folder, with these parameters; ``log``: what it wrote there."""

    def __init__(self, path, folder, **parameters):
        fmpy = pytest.importorskip("fmpy", reason=WITHOUT)
        from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

        model = fmpy.read_model_description(str(path))
        self.place = {each.name: each.valueReference for each in model.modelVariables}
        self.kind = {each.name: each.type for each in model.modelVariables}
        self.period, self.now, self.log = float(model.defaultExperiment.stepSize), 0.0, []
        self.slave = FMU2Slave(
            guid=model.guid,
            unzipDirectory=fmpy.extract(str(path), unzipdir=str(folder)),
            modelIdentifier=model.coSimulation.modelIdentifier,
        )
        log = fmi2CallbackLoggerTYPE(lambda *given: self.log.append(given[4].decode()))
        self._callbacks = fmi2CallbackFunctions(logger=log)
        self.slave.instantiate(callbacks=self._callbacks)
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.put(**parameters)
        self.slave.exitInitializationMode()

    def put(self, **values):
        for name, value in values.items():
            getattr(self.slave, f"set{self.kind[name]}")([self.place[name]], [value])

    def get(self, *names):
        return [
            getattr(self.slave, f"get{self.kind[name]}")([self.place[name]])[0] for name in names
        ]

    def step(self, **inputs):
        """One step of the unit's own length; its time goes on."""
        self.put(**inputs)
        self.slave.doStep(self.now, self.period)
        self.now += self.period
