"""Where the repository lies; and other people's models and scans, without which tests that need them are skipped."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TESTS = ROOT / "tests"
DATA = ROOT.parent / "shared" / "data"
