"""The laws that come with Zenvoy. Each module here has a record `LAW`."""
