"""Where bodies go by their routing tables: in flows that remain, and in flows that change."""
