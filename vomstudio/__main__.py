"""Entry point of the program, for its command and for `python -m vomstudio`."""

from vomstudio.core.early_stop import handle_signals

handle_signals()

from vomstudio.app import main  # noqa: E402 - reading it takes longer than all that is before it

__all__ = ["main"]

if __name__ == "__main__":
    raise SystemExit(main())
