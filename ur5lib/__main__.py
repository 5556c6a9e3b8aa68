"""`python -m ur5lib` is `ur5`, where that is not in the PATH."""

from ur5lib.cli import main

if __name__ == "__main__":
    main()
