"""Results for people: text, plots, HTML pages, recordings for the rerun viewer, and the files of each command.

Where a new part goes (one function, class or line each; nothing else changes):

- section of a page: a ``draw_...`` function in `reports.plots`, and a `Section` in ``SECTIONS`` of the module in
  `reports.pages` (`Section` is in `reports.pages.section`);
- score: an entry of ``SCORE_DEFINITIONS`` in `validation.scoring.definitions` and the computation in
  `validation.scoring`; score table, ranking, JSON and notes follow;
- plot outside a page: a ``draw_...`` function in `reports.plots`, and a line in ``EXAMPLES`` of the plots' test;
- column or row of a table: a function in `reports.text`, which pages, viewer and terminal share;
- anything shown of a diagnosis: a field of its presentation in `reports.presentation`, computed once for page, viewer,
  terminal and notebook;
- view of a recording: a function in `reports.viewer`, the only place that imports rerun;
- file of a command: a function in `reports.outputs`.
"""
