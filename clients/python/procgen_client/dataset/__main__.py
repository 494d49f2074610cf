"""python -m procgen_client.dataset: as procgen-dataset."""

import sys

from procgen_client.dataset.cli import main

if __name__ == "__main__":
    sys.exit(main())
