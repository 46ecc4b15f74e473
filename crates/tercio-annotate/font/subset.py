# Makes the fonts of crates/tercio-annotate/font from those of the npm package inter-ui 4.1.1.
import sys
from fontTools.ttLib import TTFont
from fontTools import subset
src, dst = sys.argv[1:3]
ranges=[(0x20,0x7e),(0xa0,0x17f),(0x192,0x192),(0x1e4,0x1ff),(0x218,0x21b),(0x2b0,0x2b0),(0x2c6,0x2dd),(0x300,0x30c),(0x323,0x328),
 (0x370,0x3ff),(0x1e00,0x1eff),(0x2010,0x2027),(0x2030,0x203a),(0x2044,0x2044),(0x2052,0x2052),(0x2070,0x209c),(0x20ac,0x20ac),
 (0x2103,0x2103),(0x2109,0x2109),(0x2113,0x2113),(0x2116,0x2116),(0x2122,0x2122),(0x2126,0x2126),(0x212b,0x212b),(0x2150,0x215f),(0x2190,0x2199),(0x21d0,0x21d5),
 (0x2200,0x22ff),(0x25a0,0x25cf),(0x2713,0x2717)]
f=TTFont(src)
# Figures of one width, for columns of numbers.
order=set(f.getGlyphOrder())
for t in f['cmap'].tables:
    for c,g in list(t.cmap.items()):
        if 0x30<=c<=0x39 and g+'.tf' in order: t.cmap[c]=g+'.tf'
        if c in (0x2b,0x2d,0x2212,0x2e,0x2c) and False: pass
o=subset.Options(); o.layout_features=['kern','mark','mkmk']; o.hinting=False; o.name_IDs=[0,1,2,3,4,5,6,13,14]; o.notdef_outline=True; o.glyph_names=False; o.drop_tables+=['DSIG','GDEF'] if False else ['DSIG']
o.recalc_bounds=True
s=subset.Subsetter(o); s.populate(unicodes=[u for a,b in ranges for u in range(a,b+1)]); s.subset(f)
f.flavor=None; f.save(dst)
print(dst, len(f.getGlyphOrder()), [ (t,len(f.reader[t]) if 0 else 0) for t in f.keys()])
