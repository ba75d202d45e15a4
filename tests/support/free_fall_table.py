#!/usr/bin/env python3
"""Makes tests/unit/geo_free_fall_table.hpp: where bodies come down, by an integration that shares nothing with src/geo.

    tests/support/free_fall_table.py | clang-format-14 --assume-filename=.hpp > tests/unit/geo_free_fall_table.hpp

(python3-mpmath, a minute.)

Axes that do not rotate with the Earth, so that there is neither a centrifugal nor a Coriolis force; gravity as the gradient of the
potential mu/r [1 - J2 (a/r)^2 P2(sin latitude)]; Gragg, Bulirsch and Stoer's extrapolation of the modified midpoint rule to order 24 with
30 digits, in steps of 50 s (half of that moves no row by 1e-9 m); the instant of landing by bisection of the geodetic height, itself by
Newton's method on the foot of the normal. Constants: the ellipsoid of WGS 84 (NIMA TR8350.2, third edition, 2000): a, 1/f, GM, omega, and
J2 = -C20 sqrt(5) of its normalised C20 = -4.84166774985e-4.
"""
from mpmath import mp, mpf, sqrt, sin, cos, atan2, radians

mp.dps = 30
A = mpf(6378137)
F = 1 / mpf("298.257223563")
E2 = F * (2 - F)
MU = mpf("3.986004418e14")
OMEGA = mpf("7.292115e-5")
J2 = mpf("4.84166774985e-4") * sqrt(5)

# name; latitude, longitude (deg), height (m); velocity east, north, up (m/s, over the ground); height of the ground (m)
CASES = [
    ("dropped", 34.4319, 127.5351, 5000, 0, 0, 0, 0),
    ("thrown up from the pad", 34.4319, 127.5351, 100, 3, -20, 150, 0),
    ("some way down range", 34.20, 127.57, 30000, 60, -400, 700, 0),
    ("100 km", 33.9, 127.6, 60000, 60, -300, 900, 0),
    ("1000 km south", 33.0, 127.8, 140000, 250, -2000, 1500, 0),
    ("1000 km east", 28.5, -80.5, 120000, 2200, 100, 1300, 0),
    ("west, against the rotation", 57.4, -152.3, 150000, -3600, -1500, 1800, 0),
    ("over the pole", 69.3, 16.0, 200000, 100, 4200, 1800, 0),
    ("over the date line", 9.4, 167.5, 250000, 4000, 1500, 1500, 0),
    ("lofted", 34.4, 127.5, 300000, 100, -900, 6500, 0),
    ("nearly around", 5.2, -52.8, 180000, 6900, 800, 900, 0),
    ("decays", -30.0, 60.0, 120000, 7200, 300, -300, 0),
    ("down to high ground", 40.9, 100.3, 90000, -900, -1100, 700, 3000),
]


def gravity(p):
    """Gradient of mu/r - mu J2 a^2 (3 z^2 - r^2) / (2 r^5)."""
    r2 = p[0] ** 2 + p[1] ** 2 + p[2] ** 2
    r = sqrt(r2)
    c = MU * J2 * A ** 2 / 2
    # d/dx [(3 z^2 - r^2) r^-5] = x (3 r^-5 - 15 z^2 r^-7); d/dz has 6 z r^-5 more
    common = -MU / r ** 3 - c * (3 / r ** 5 - 15 * p[2] ** 2 / r ** 7)
    return [p[0] * common, p[1] * common, p[2] * common - c * 6 * p[2] / r ** 5]


def f(y):
    return y[3:] + gravity(y[:3])


def combine(a, s, b):
    return [x + s * z for x, z in zip(a, b)]


def step(y, h, levels=12):
    """Gragg, Bulirsch, Stoer."""
    table = []
    d0 = f(y)
    for k in range(1, levels + 1):
        n = 2 * k
        s = h / n
        before, now = y, combine(y, s, d0)
        for _ in range(1, n):
            before, now = now, combine(before, 2 * s, f(now))
        row = [[(u + v + s * w) / 2 for u, v, w in zip(before, now, f(now))]]
        for j in range(1, k):
            factor = (mpf(k) / (k - j)) ** 2 - 1
            row.append([u + (u - v) / factor for u, v in zip(row[j - 1], table[-1][j - 1])])
        table.append(row)
    return table[-1][-1]


def after(y, t, longest):
    n = max(1, int(mp.ceil(t / longest)))
    for _ in range(n):
        y = step(y, t / n)
    return y


def geodetic(p):
    """Latitude and height; the longitude is atan2."""
    rho = sqrt(p[0] ** 2 + p[1] ** 2)
    phi = atan2(p[2], rho * (1 - E2))
    for _ in range(12):
        n = A / sqrt(1 - E2 * sin(phi) ** 2)
        # distance along the tangent of the meridian from the foot: zero at the right latitude
        g = -sin(phi) * (rho - n * cos(phi)) + cos(phi) * (p[2] - n * (1 - E2) * sin(phi))
        m = A * (1 - E2) / sqrt(1 - E2 * sin(phi) ** 2) ** 3
        h = cos(phi) * (rho - n * cos(phi)) + sin(phi) * (p[2] - n * (1 - E2) * sin(phi))
        phi += g / (m + h)
    return phi, h


def fixed(p, t):
    """Into the Earth's axes, which agree with the others at t = 0."""
    a = OMEGA * t
    return [cos(a) * p[0] + sin(a) * p[1], -sin(a) * p[0] + cos(a) * p[1], p[2]]


def start_of(case):
    _, lat, lon, height, east, north, up, _ = case
    lat, lon = radians(mpf(str(lat))), radians(mpf(str(lon)))
    n = A / sqrt(1 - E2 * sin(lat) ** 2)
    p = [(n + height) * cos(lat) * cos(lon), (n + height) * cos(lat) * sin(lon), (n * (1 - E2) + height) * sin(lat)]
    e = [-sin(lon), cos(lon), mpf(0)]
    m = [-sin(lat) * cos(lon), -sin(lat) * sin(lon), cos(lat)]
    u = [cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)]
    v = [east * e[i] + north * m[i] + up * u[i] for i in range(3)]
    return p, v


def land(case, longest):
    p, v = start_of(case)
    ground = case[7]
    y = p + [v[0] - OMEGA * p[1], v[1] + OMEGA * p[0], v[2]]
    t = mpf(0)
    while True:
        z = after(y, longest, longest)
        if geodetic(z[:3])[1] < ground:
            break
        y, t = z, t + longest
        assert t < 10000, case
    low, high = mpf(0), mpf(longest)
    # height is above at 0 (or at the start, rising) and below at the end
    for _ in range(80):
        middle = (low + high) / 2
        z = step(y, middle)
        rising = sum(a * b for a, b in zip(z[:3], z[3:])) > 0
        if geodetic(z[:3])[1] > ground or (rising and t == 0):
            low = middle
        else:
            high = middle
    z = step(y, high)
    return fixed(z[:3], t + high), t + high


print("#pragma once")
print("/// Made by tests/support/free_fall_table.py, which says how. Not to be edited.")
print()
print("#include <array>")
print()
print("namespace downrange::test {")
print()
print("struct TabulatedFall {")
print("  const char* name;")
print("  double latitude_deg, longitude_deg, height_m;  ///< start, and velocity over the ground")
print("  double east_m_s, north_m_s, up_m_s;")
print("  double ground_m;  ///< height that it comes down to")
print("  double x_m, y_m, z_m, time_s;  ///< where and when, Earth-fixed")
print("};")
print()
print(f"inline constexpr std::array<TabulatedFall, {len(CASES)}> tabulated_falls{{{{")
for case in CASES:
    p, t = land(case, 50)
    q, s = land(case, 25)
    assert max(abs(a - b) for a, b in zip(p, q)) < 1e-9, (case, p, q)
    numbers = ", ".join(str(x) for x in case[1:])
    where = ", ".join(mp.nstr(x, 16) for x in p)
    print(f'    {{"{case[0]}", {numbers}, {where}, {mp.nstr(t, 16)}}},')
print("}};")
print()
print("}  // namespace downrange::test")
