# The public names: imported when first used (`__init__.py`), and what type checkers see.
from .clouds.cloud import Cloud as Cloud
from .clouds.cloud import cloud_from_mesh as cloud_from_mesh
from .clouds.cloud import cloud_from_points as cloud_from_points
from .clouds.cloud import load_cloud as load_cloud
from .clouds.conversion import as_cloud as as_cloud
from .datasets.dataset import open_dataset as open_dataset
from .errors import InputError as InputError
from .formats.units import parse_length as parse_length
from .function_model import Membership as Membership
from .learning.classifier import CloudClassifier as CloudClassifier
from .learning.cube_classifier import CubeClassifier as CubeClassifier
from .learning.function_classifier import FunctionClassifier as FunctionClassifier
from .learning.histogram import CubeHistogram as CubeHistogram
from .learning.histogram import SphereHistogram as SphereHistogram
from .learning.inverse_distance import InverseDistanceClassifier as InverseDistanceClassifier
from .learning.model_file import load_model as load_model
from .learning.model_file import save_model as save_model
from .learning.model_file import shipped_model as shipped_model
from .learning.reasons.answer import Answer as Answer
from .learning.reasons.answer import classify as classify
from .learning.resting_profile import RestingProfile as RestingProfile
from .places.place import Place as Place
from .scenes.arrangements.placing import Placement as Placement
from .scenes.arrangements.together import together as together
from .scenes.recognition.objects import FoundObject as FoundObject
from .scenes.recognition.objects import find_objects as find_objects
from .scenes.recognition.places import find_places as find_places
from .shapes.compared import Shapes as Shapes
from .shapes.compared import compare_shapes as compare_shapes
from .simulator import DropResult as DropResult
from .simulator import DropSettings as DropSettings
from .simulator import Outcome as Outcome
from .simulator import Simulator as Simulator
from .simulator import Stop as Stop
from .simulator import make_simulator as make_simulator

__version__: str
