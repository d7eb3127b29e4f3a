"""``python -m dmil`` is ``dmil``."""

from dmil.cli import main

if __name__ == "__main__":
    main()
