"""The laws that come with Zenvoy, one module each: every module here has a record `LAW`."""
