"""The checker of accessibility that tests have look at pages."""

from importlib import resources

AXE = resources.files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8")
FINDINGS = """async () => {
    const { violations } = await axe.run(document, { resultTypes: ["violations"] });
    return violations
        .filter(({ impact }) => impact === "serious" || impact === "critical")
        .flatMap(({ id, nodes }) => nodes.map(node => [id, node.target.join(" "), node.html]));
}"""
"""What the checker finds that keeps people out. It loads nothing from elsewhere."""
