"""The event store: runs as append-only events in one database, and pure views of them.

``run_events`` says what can happen to a run, ``views`` what its events amount to, ``exploration`` what an attempt is, ``rules`` what its history
allows next, ``database`` where events are kept, ``schema`` in which tables, ``migrations`` how those of earlier versions
become these, ``owners`` whose runs are whose, ``limits`` how much an owner may have, ``run_ids`` how runs are named, and
``run_store`` joins them in ``RunStore``, the one class that the tools use. The store knows no geometry: a state is the
list of the actions that lead to it from the flat sheet.
"""
