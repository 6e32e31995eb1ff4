"""What several tests need: a person at the page, a lab, folders of results, a server."""
