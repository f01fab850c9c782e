"""HTML pages of results, each self-contained.

A new section of a page: one ``draw_...`` function in `reports.plots` and one `Section` in the page's ``SECTIONS``.
"""
