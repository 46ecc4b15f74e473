"""Makes Inter-Medium.ttf from package/web/Inter-Medium.woff2 of the npm package inter-ui 4.1.1:

    pip install fonttools brotli
    python subset.py Inter-Medium.woff2 Inter-Medium.ttf

Figures are replaced by those of one width, for columns of numbers. Names and licence stay in the file.
"""
import sys

from fontTools import subset
from fontTools.ttLib import TTFont

RANGES = [
    (0x20, 0x7E), (0xA0, 0x17F), (0x192, 0x192), (0x1E4, 0x1FF), (0x218, 0x21B), (0x2B0, 0x2B0), (0x2C6, 0x2DD),  # Latin
    (0x300, 0x30C), (0x323, 0x328),  # combining marks
    (0x370, 0x3FF), (0x1E00, 0x1EFF),  # Greek, more Latin
    (0x2010, 0x2027), (0x2030, 0x203A), (0x2044, 0x2044), (0x2052, 0x2052),  # punctuation
    (0x2070, 0x209C), (0x20AC, 0x20AC), (0x2103, 0x2103), (0x2109, 0x2109), (0x2113, 0x2113), (0x2116, 0x2116),
    (0x2122, 0x2122), (0x2126, 0x2126), (0x212B, 0x212B), (0x2150, 0x215F),  # superscripts, units, fractions
    (0x2190, 0x2199), (0x21D0, 0x21D5), (0x2200, 0x22FF), (0x25A0, 0x25CF), (0x2713, 0x2717),  # arrows, mathematics, shapes
]

font = TTFont(sys.argv[1])
names = set(font.getGlyphOrder())
for table in font["cmap"].tables:
    for character, glyph in list(table.cmap.items()):
        if 0x30 <= character <= 0x39 and glyph + ".tf" in names:
            table.cmap[character] = glyph + ".tf"
options = subset.Options()
options.layout_features = ["kern", "mark", "mkmk"]
options.hinting = False
options.name_IDs = [0, 1, 2, 3, 4, 5, 6, 13, 14]
options.glyph_names = False
options.notdef_outline = True
subsetter = subset.Subsetter(options)
subsetter.populate(unicodes=[c for first, last in RANGES for c in range(first, last + 1)])
subsetter.subset(font)
font.flavor = None
font.save(sys.argv[2])
