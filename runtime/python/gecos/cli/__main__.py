import sys

from gecos.cli import main

sys.exit(main())
