"""The FMI 2.0 binary of an FMU, called as an importer does."""

import ctypes
import zipfile
from xml.etree import ElementTree

POINTER, DOUBLE, SIZE = ctypes.c_void_p, ctypes.c_double, ctypes.c_size_t
LOGGER = ctypes.CFUNCTYPE(
    None, POINTER, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p
)
GOOD, WARNING, ERROR = 0, 1, 3


class Callbacks(ctypes.Structure):
    _fields_ = [
        ("logger", LOGGER),
        ("allocate", POINTER),
        ("free", POINTER),
        ("finished", POINTER),
        ("environment", POINTER),
    ]


class Slave:
    """An instance; ``told`` are the statuses and texts that it has logged."""

    def __init__(self, fmu, folder, token=None):
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(folder)
        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
        self.every = float(root.find("DefaultExperiment").get("stepSize"))
        self.names = {
            x.get("name"): int(x.get("valueReference")) for x in root.iter("ScalarVariable")
        }
        model = root.find("CoSimulation").get("modelIdentifier")
        self.library = ctypes.CDLL(str(folder / "binaries" / "linux64" / f"{model}.so"))
        self.told = []
        logger = LOGGER(
            lambda _, name, status, category, form, text: self.told.append((status, text))
        )
        self.callbacks = Callbacks(logger)
        instantiate = self.library.fmi2Instantiate
        instantiate.restype = POINTER
        own = (token or root.get("guid")).encode()
        self.instance = instantiate(b"one", 1, own, b"", ctypes.byref(self.callbacks), 0, 0)
        self.time = 0.0

    def call(self, name, *arguments):
        return getattr(self.library, f"fmi2{name}")(POINTER(self.instance), *arguments)

    def begin(self, **values):
        self.call("SetupExperiment", 0, DOUBLE(0.0), DOUBLE(0.0), 0, DOUBLE(0.0))
        self.call("EnterInitializationMode")
        found = self.put(**values)
        return max(found, self.call("ExitInitializationMode"))

    def put(self, **values):
        """Set variables; "__" stands for a dot."""
        worst = GOOD
        for name, value in values.items():
            reference = ctypes.c_uint(self.names[name.replace("__", ".")])
            number = DOUBLE(value)
            status = self.call("SetReal", ctypes.byref(reference), SIZE(1), ctypes.byref(number))
            worst = max(worst, status)
        return worst

    def get(self, name):
        number, reference = DOUBLE(), ctypes.c_uint(self.names[name])
        self.call("GetReal", ctypes.byref(reference), SIZE(1), ctypes.byref(number))
        return number.value

    def step(self, step=None):
        found = self.call("DoStep", DOUBLE(self.time), DOUBLE(step or self.every), 1)
        if found < ERROR:
            self.time += self.every
        return found

    def kept(self):
        state = POINTER()
        assert self.call("GetFMUstate", ctypes.byref(state)) == GOOD
        return state

    def written(self, state):
        size = SIZE()
        self.call("SerializedFMUstateSize", state, ctypes.byref(size))
        buffer = ctypes.create_string_buffer(size.value)
        assert self.call("SerializeFMUstate", state, buffer, size) == GOOD
        return buffer.raw

    def read(self, data):
        state = POINTER()
        return self.call("DeSerializeFMUstate", data, SIZE(len(data)), ctypes.byref(state)), state
