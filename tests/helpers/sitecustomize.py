"""What Python imports at its start, in processes that tests begin under ``HFC_BARE=1``."""

import os

if os.environ.get("HFC_BARE"):
    import bare  # noqa: F401
