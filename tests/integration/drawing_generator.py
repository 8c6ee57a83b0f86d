"""Random drawings of loops as people make them: with and without ids, as shapes, paths, outlines, arcs that meet or leave gaps and
polylines that end on themselves, nested, in chains, with pads, leads, names, connections and layers, moved and turned by
transforms. Each knows how long its lines are."""
import dataclasses
import math
import random


@dataclasses.dataclass
class Drawing:
    svg: str
    lengths: list  # of all stroked lines, mm
    ids: dict      # of an id: the lengths of its lines; empty where some lines are in no coil


class Generator:
    def __init__(self, seed):
        self.random = random.Random(seed)

    def drawing(self, most_mm):
        """On a page of at most so many mm."""
        while True:
            drawing = self.attempt(most_mm)
            if drawing.lengths:  # of a chain, no loop may fit on the page
                return drawing

    def attempt(self, most_mm):
        r = self.random
        self.lengths, self.ids, self.joined = [], {}, False
        self.width_mm, self.height_mm = r.uniform(60, most_mm), r.uniform(60, most_mm)
        self.named = r.random() < 0.5
        unit = r.choice([1, 1, 2.834645669, 10])  # user units per mm
        body = "".join(r.choice([self.chain, self.scattered, self.nested, self.butterfly, self.connected])() for _ in range(r.randint(1, 3)))
        if r.random() < 0.3:
            body = f'<g inkscape:groupmode="layer" id="layer1" inkscape:label="Coils">{body}</g>'
        if r.random() < 0.3:
            body = f"<defs/><metadata>made</metadata>{body}"
        box = f'viewBox="0 0 {self.width_mm * unit:.4f} {self.height_mm * unit:.4f}"'
        scaled = f'<g transform="scale({unit})">{body}</g>'
        svg = (f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
               f'width="{self.width_mm:.4f}mm" height="{self.height_mm:.4f}mm" {box} fill="none" stroke="#000" '
               f'stroke-width="{r.uniform(0.4, 2.5):.3f}">\n{scaled}\n</svg>\n')
        return Drawing(svg, self.lengths, {} if self.joined else self.ids)

    # Groups of loops

    def place(self, reach):
        """A centre from which `reach` mm stay on the page."""
        r = self.random
        return (r.uniform(min(reach, self.width_mm / 2), max(self.width_mm - reach, self.width_mm / 2)),
                r.uniform(min(reach, self.height_mm / 2), max(self.height_mm - reach, self.height_mm / 2)))

    def largest(self):
        return min(self.width_mm, self.height_mm) / 2 - 3

    def element(self, parts):
        """One coil: (markup, length) of its lines, and maybe what belongs to it."""
        lengths = [length for _, length in parts if length]
        self.lengths += lengths
        text = "".join(markup for markup, _ in parts)
        if not self.named:
            return text if self.random.random() < 0.5 else f"<g>{text}</g>"
        name = f"coil {len(self.ids) + 1}" if self.random.random() < 0.2 else f"L{len(self.ids) + 1}"
        self.ids[name] = lengths
        return f'<g id="{name}">{text}</g>'

    def chain(self):
        """Overlapping circles in a row or on an arc."""
        r = self.random
        radius, count, turn = r.uniform(8, min(20, self.largest())), r.randint(2, 5), r.uniform(0, 2 * math.pi)
        x, y = self.place(radius)
        out = ""
        for i in range(count):
            cx, cy = x + 1.5 * radius * i * math.cos(turn), y + 1.5 * radius * i * math.sin(turn)
            if not (radius + 2 < cx < self.width_mm - radius - 2 and radius + 2 < cy < self.height_mm - radius - 2):
                continue
            out += self.element([self.circle(cx, cy, radius)] + self.extras(cx, cy, radius))
        return out

    def scattered(self):
        out = ""
        for _ in range(self.random.randint(1, 3)):
            radius = self.random.uniform(8.5, min(28, self.largest()))  # smaller loops within others are marks
            cx, cy = self.place(radius + 2)
            make = self.random.choice([self.circle, self.rectangle, self.polygon, self.rounded, self.outlined, self.gapped,
                                       self.in_arcs, self.polyline])
            made = make(cx, cy, radius)
            out += self.element((made if isinstance(made, list) else [made]) + self.extras(cx, cy, radius))
        return out

    def nested(self):
        radius = self.random.uniform(15, min(30, self.largest()))
        cx, cy = self.place(radius + 2)
        inner = radius * self.random.uniform(0.3, 0.7)
        return self.element([self.circle(cx, cy, radius)]) + self.element([self.circle(cx + 0.1 * radius, cy, inner)])

    def connected(self):
        """Two loops and a line from one to the other."""
        r = self.random
        radius, apart = r.uniform(7, 12), r.uniform(2.6, 3.5)
        cx, cy = self.place(radius + 2)
        x = cx + apart * radius
        if x + radius + 2 > self.width_mm:
            x = cx - apart * radius
        if x - radius - 2 < 0:
            return self.element([self.circle(cx, cy, radius)])
        side = math.copysign(radius, x - cx)
        out = self.element([self.circle(cx, cy, radius)]) + self.element([self.circle(x, cy, radius)])
        markup, length = self.path([(cx + side, cy), (x - side, cy)], closed=False)
        self.lengths.append(length)
        self.joined = True
        return out + markup

    def butterfly(self):
        """Two loops in series, crossing in the middle."""
        w = self.random.uniform(10, min(22, self.largest()))
        cx, cy = self.place(w + 2)
        points = [(cx - w, cy - w / 2), (cx + w, cy + w / 2), (cx + w, cy - w / 2), (cx - w, cy + w / 2)]
        return self.element([self.path(points, closed=True)])

    def extras(self, cx, cy, radius):
        """Pads, leads and ports inside of a loop or touching it."""
        r = self.random
        out = []
        if r.random() < 0.4:  # a pad on the line
            turn, size = r.uniform(0, 2 * math.pi), r.uniform(2, 4)
            x, y = cx + radius * math.cos(turn), cy + radius * math.sin(turn)
            out.append((f'<rect x="{x - size / 2:.4f}" y="{y - size / 2:.4f}" width="{size:.4f}" height="{size:.4f}" fill="#000" stroke="none"/>', 0))
        if r.random() < 0.2:  # a lead inwards
            turn = r.uniform(0, 2 * math.pi)
            out.append(self.path([(cx + 0.9 * radius * math.cos(turn), cy + 0.9 * radius * math.sin(turn)),
                                  (cx + 0.3 * radius * math.cos(turn), cy + 0.3 * radius * math.sin(turn))], closed=False))
        if r.random() < 0.1:  # its name
            out.append((f'<text x="{cx - 3:.4f}" y="{cy + 1:.4f}" font-size="4" fill="#000" stroke="none">R{r.randint(1, 64)}</text>', 0))
        return out

    # Lines: (markup, length), or a list of them

    def arc(self, cx, cy, radius, begin, end):
        """A circular arc as a path."""
        x0, y0, x1, y1 = (c for a in (begin, end) for c in (cx + radius * math.cos(a), cy + radius * math.sin(a)))
        return (f'<path d="M{x0:.4f} {y0:.4f}A{radius:.4f} {radius:.4f} 0 {int(end - begin > math.pi)} 1 {x1:.4f} {y1:.4f}"/>',
                radius * (end - begin))

    def in_arcs(self, cx, cy, radius):
        """A circle of arcs, each a path of its own, as CAD programs write it."""
        count, turn = self.random.randint(2, 5), self.random.uniform(0, 2 * math.pi)
        arcs = [self.arc(cx, cy, radius, turn + 2 * math.pi * i / count, turn + 2 * math.pi * (i + 1) / count) for i in range(count)]
        self.random.shuffle(arcs)
        return arcs

    def gapped(self, cx, cy, radius):
        """A circle with gaps for capacitors."""
        count, turn, gap = self.random.randint(2, 4), self.random.uniform(0, 2 * math.pi), self.random.uniform(0.8, 2) / radius
        return [self.arc(cx, cy, radius, turn + 2 * math.pi * i / count + gap, turn + 2 * math.pi * (i + 1) / count) for i in range(count)]

    def outlined(self, cx, cy, radius):
        """The stroke of a circle as a filled outline."""
        width = self.random.uniform(0.8, 2)
        d = "".join(f"M{cx - r:.4f} {cy:.4f}a{r:.4f} {r:.4f} 0 1 {sweep} {2 * r:.4f} 0a{r:.4f} {r:.4f} 0 1 {sweep} {-2 * r:.4f} 0z"
                    for r, sweep in ((radius + width / 2, 1), (radius - width / 2, 0)))
        return f'<path d="{d}" fill="#000" stroke="none"/>', 2 * math.pi * radius

    def polyline(self, cx, cy, radius):
        """A circle as many short lines that ends where it begins, or a little farther."""
        count, turn = self.random.randint(60, 200), self.random.uniform(0, 2 * math.pi)
        corners = range(count + 1 + self.random.choice([0, 1, 2]))
        return self.path([(cx + radius * math.cos(turn + 2 * math.pi * i / count), cy + radius * math.sin(turn + 2 * math.pi * i / count)) for i in corners],
                         closed=False)

    def circle(self, cx, cy, radius):
        length = 2 * math.pi * radius
        kind = self.random.randrange(4)
        if kind == 0:
            return f'<circle cx="{cx:.4f}" cy="{cy:.4f}" r="{radius:.4f}"/>', length
        if kind == 1:  # as AutoCAD's and Illustrator's exports have it
            return f'<path d="M{cx - radius:.4f} {cy:.4f}a{radius:.4f},{radius:.4f} 0 1,0 {2 * radius:.4f},0a{radius:.4f},{radius:.4f} 0 1,0 {-2 * radius:.4f},0z"/>', length
        if kind == 2:  # four cubics
            k = 0.5522847498 * radius
            return (f'<path d="M{cx + radius:.4f},{cy:.4f}c0,{k:.4f} {k - radius:.4f},{radius:.4f} {-radius:.4f},{radius:.4f}'
                    f's{-radius:.4f},{k - radius:.4f} {-radius:.4f},{-radius:.4f} {radius - k:.4f},{-radius:.4f} {radius:.4f},{-radius:.4f} '
                    f'{radius:.4f},{radius - k:.4f} {radius:.4f},{radius:.4f}Z"/>', length)
        turn = self.random.uniform(0, 360)
        return f'<g transform="translate({cx:.4f} {cy:.4f}) rotate({turn:.2f})"><ellipse rx="{radius / 2:.5f}" ry="{radius / 2:.5f}" transform="scale(2)" stroke-width="0.5"/></g>', length

    def rectangle(self, cx, cy, radius):
        w, h = radius * self.random.uniform(0.9, 1.4), radius * self.random.uniform(0.8, 1.4)
        turn = self.random.uniform(0, 90)
        return (f'<rect x="{cx - w / 2:.4f}" y="{cy - h / 2:.4f}" width="{w:.4f}" height="{h:.4f}" transform="rotate({turn:.2f} {cx:.4f} {cy:.4f})"/>',
                2 * (w + h))

    def rounded(self, cx, cy, radius):
        w, h = radius * self.random.uniform(1.0, 1.4), radius * self.random.uniform(0.8, 1.4)
        r = 0.25 * min(w, h)
        return (f'<rect x="{cx - w / 2:.4f}" y="{cy - h / 2:.4f}" width="{w:.4f}" height="{h:.4f}" rx="{r:.4f}"/>',
                2 * (w + h) - 8 * r + 2 * math.pi * r)

    def polygon(self, cx, cy, radius):
        corners, turn = self.random.choice([3, 5, 6, 8]), self.random.uniform(0, 2 * math.pi)
        points = [(cx + radius * math.cos(turn + 2 * math.pi * i / corners), cy + radius * math.sin(turn + 2 * math.pi * i / corners)) for i in range(corners)]
        return self.path(points, closed=True)

    def path(self, points, closed):
        length = sum(math.dist(a, b) for a, b in zip(points, points[1:] + (points[:1] if closed else [])))
        d = "M" + " L".join(f"{x:.4f},{y:.4f}" for x, y in points) + ("Z" if closed else "")
        return f'<path d="{d}"/>', length
