from vomstudio.app import main

raise SystemExit(main())
