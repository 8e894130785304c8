"""The C functions that exported systems share: each piece goes into a file only when its system needs it.

`fz_` becomes the name of the system, so that two exported systems fit into one program. The pieces follow the kernel
line by line (`control.fuzzy.degree`, `ordered`, `area`), so that both give the same numbers.
"""

HEAD = """\
#include <float.h>

#ifndef FUZZY_REAL
#define FUZZY_REAL double /* or float: define FUZZY_REAL before this line, or with -DFUZZY_REAL=float */
#endif
typedef FUZZY_REAL fz_real;
#define FZ_R(number) ((fz_real)(number))
#define FZ_NONE (FZ_R(0) / FZ_R(0)) /* not a number */
#if DBL_MIN_10_EXP < -290 /* a rule fainter than this does not fire */
#define FZ_FAINT (sizeof(fz_real) > sizeof(float) ? FZ_R(1e-290) : FZ_R(FLT_MIN))
#else
#define FZ_FAINT FZ_R(FLT_MIN)
#endif
"""

CLAMP = """\
static fz_real fz_clamped(fz_real x, fz_real low, fz_real high, int clamp)
{
    if (!clamp)
        return x;
    x = x < low ? low : x;
    return x > high ? high : x;
}
"""

HEARD = """\
static fz_real fz_heard(fz_real strength)
{
    return strength > FZ_FAINT ? strength : FZ_R(0);
}
"""

TRAPEZOID = """\
/* Feet a and d, top from b to c; an upright side belongs to the set. */
static fz_real fz_trapezoid(fz_real a, fz_real b, fz_real c, fz_real d, fz_real x)
{
    if (x < a || x > d)
        return 0;
    if (x < b)
        return (x - a) / (b - a);
    return x <= c ? FZ_R(1) : (d - x) / (d - c);
}
"""

POLYLINE = """\
/* n points (place, height): straight between them, level beyond; where it jumps, the greatest height counts. */
static fz_real fz_polyline(const fz_real *p, int n, fz_real x)
{
    fz_real mu = 0;
    int k;
    if (x < p[0])
        return p[1];
    if (x > p[2 * n - 2])
        return p[2 * n - 1];
    for (k = 0; k < n - 1; ++k, p += 2) {
        if (p[0] < x && x < p[2])
            return p[1] + (p[3] - p[1]) * ((x - p[0]) / (p[2] - p[0]));
        if (x == p[0] && p[1] > mu)
            mu = p[1];
        if (x == p[2] && p[3] > mu)
            mu = p[3];
    }
    return mu;
}
"""

GAUSSIAN = """\
static fz_real fz_gaussian(fz_real mean, fz_real sigma, fz_real x)
{
    fz_real z = (x - mean) / sigma;
    return (fz_real)exp(-0.5 * z * z);
}
"""

BELL = """\
static fz_real fz_bell(fz_real a, fz_real b, fz_real centre, fz_real x)
{
    return (fz_real)(1.0 / (1.0 + pow(fabs((x - centre) / a), 2.0 * b)));
}
"""

_JOIN = """\
static fz_real fz_{name}(fz_real a, fz_real b)
{{
    return {value};
}}
"""
AND = {
    "min": _JOIN.format(name="and", value="b < a ? b : a"),
    "prod": _JOIN.format(name="and", value="a * b"),
    "bounded": _JOIN.format(name="and", value="a + b - 1 > 0 ? a + b - 1 : FZ_R(0)"),
}
OR = {
    "max": _JOIN.format(name="or", value="b > a ? b : a"),
    "probor": _JOIN.format(name="or", value="a + b - a * b"),
    "bounded": _JOIN.format(name="or", value="a + b < 1 ? a + b : FZ_R(1)"),
}

RAISE = {
    "max": """\
static void fz_raise(fz_real *height, fz_real strength)
{
    if (strength > *height)
        *height = strength;
}
""",
    "sum": """\
static void fz_raise(fz_real *height, fz_real strength)
{
    *height += strength;
}
""",
}

# Closed form: sets from left to right, of which only neighbours overlap.
ORDERED = """\
struct fz_union {
    fz_real area, moment;
    fz_real before, c, d; /* height and falling side of the set on the left */
};

static void fz_piece(struct fz_union *u, fz_real a, fz_real p, fz_real q, fz_real d, fz_real h)
{
    fz_real left = (p - a) / 2, top = q - p, right = (d - q) / 2;
    u->area += h * (left + top + right);
    u->moment += h * (left * (a + 2 * p) / 3 + top * (p + q) / 2 + right * (2 * q + d) / 3);
}

/* The next set, at height h: added, less what it shares with the one on its left. */
static void fz_next(struct fz_union *u, fz_real a, fz_real b, fz_real c, fz_real d, fz_real h)
{
    if (h > 0) {
        fz_piece(u, a, @P@, @Q@, d, h);
        if (u->before > 0 && u->d > a) {
            fz_real rise = @RISE@, fall = @FALL@, top = (u->d - a) / (rise + fall);
            top = u->before < top ? u->before : top;
            top = h < top ? h : top;
            fz_piece(u, a, a + top * rise, u->d - top * fall, u->d, -top);
        }
        u->c = c;
        u->d = d;
    }
    u->before = h;
}
"""
CUT = {"@P@": "a + h * (b - a)", "@Q@": "d - h * (d - c)", "@RISE@": "b - a", "@FALL@": "u->d - u->c"}
SCALED = {"@P@": "b", "@Q@": "c", "@RISE@": "(b - a) / h", "@FALL@": "(u->d - u->c) / u->before"}

# General: in each cell between neighbouring break points every set is a line with a lid.
LINES = """\
struct fz_line {
    fz_real left, right, lid; /* height at the cell's ends; where it is cut off */
};

/* One more line of a cell, if its set is raised at all; gives the new count. */
static int fz_line(struct fz_line *l, int n, fz_real left, fz_real right, fz_real height)
{
    if (!(height > 0))
        return n;
    l[n].left = @SCALE@left;
    l[n].right = @SCALE@right;
    l[n].lid = height;
    return n + 1;
}

/* The place where a difference that goes from d0 to d1 is 0, put in order among n others; gives the new count.
   A place is a share of the cell to its left and the rest to its right: near an end only one keeps its digits. */
static int fz_cross(fz_real *at, fz_real *rest, int n, fz_real d0, fz_real d1)
{
    fz_real share, other;
    int k;
    if (!((d0 < 0 && 0 < d1) || (d1 < 0 && 0 < d0)))
        return n;
    share = d0 / (d0 - d1);
    other = d1 / (d1 - d0);
    for (k = n; at[k - 1] > share || (!(at[k - 1] < share) && rest[k - 1] < other); --k) {
        at[k] = at[k - 1];
        rest[k] = rest[k - 1];
    }
    at[k] = share;
    rest[k] = other;
    return n + 1;
}

static fz_real fz_height(const struct fz_line *l, int n, fz_real share, fz_real rest)
{
    fz_real total = 0, y;
    int i;
    for (i = 0; i < n; ++i) {
        y = l[i].left * rest + l[i].right * share;
@LID@        @JOIN@
    }
    return total;
}
"""

FOLD = """\
struct fz_fold {
    fz_real total, moment, peak; /* area, first moment, greatest height */
@FIELDS@};

static void fz_points(struct fz_fold *f, const fz_real *u, const fz_real *y, int n)
{
    int k;
@SECOND@    for (k = 0; k < n - 1; ++k) {
        fz_real width = u[k + 1] - u[k], size = width * (y[k] + y[k + 1]) / 2;
        f->total += size;
        f->moment += u[k] * size + width * width * (y[k] + 2 * y[k + 1]) / 6;
        f->peak = y[k] > f->peak ? y[k] : f->peak;
        f->peak = y[k + 1] > f->peak ? y[k + 1] : f->peak;
    }
}

static void fz_cell(struct fz_fold *f, fz_real left, fz_real right, const struct fz_line *l, int n)
{
    fz_real u[@POINTS@], y[@POINTS@];
    int i, count = 2;
@DECLARE@    if (n == 0)
        return;
    u[0] = y[1] = 0;
    u[1] = y[0] = 1;
@CROSSINGS@    for (i = 0; i < count; ++i) {
        fz_real share = u[i];
        u[i] = share == 1 ? right : left + share * (right - left);
        y[i] = fz_height(l, n, share, y[i]);
    }
    fz_points(f, u, y, count);
}
"""
LID = """\
        y = l[i].lid < y ? l[i].lid : y;
"""
LIDS_CROSS = """\
        count = fz_cross(u, y, count, l[i].left - l[i].lid, l[i].right - l[i].lid);
"""
LINES_CROSS = """\
        for (j = 0; j < i; ++j)
            count = fz_cross(u, y, count, l[i].left - l[j].left, l[i].right - l[j].right);
"""
OTHER_LIDS_CROSS = """\
        for (j = 0; j < n; ++j)
            if (j != i)
                count = fz_cross(u, y, count, l[i].left - l[j].lid, l[i].right - l[j].lid);
"""

# Second passes over the cells; the first has found the area and the greatest height.
BISECTOR_FIELDS = """\
    fz_real half, done, at; /* second pass: half of the area, area so far, place so far */
    int again, found;
"""
BISECTOR = """\
    for (k = 0; f->again && !f->found && k < n - 1; ++k) {
        fz_real width = u[k + 1] - u[k], size = width * (y[k] + y[k + 1]) / 2;
        f->at = u[k] + width;
        if (f->done + size >= f->half) {
            fz_real top = y[k + 1] > y[k] ? y[k + 1] : y[k], rest = (f->half - f->done) / top;
            fz_real first = y[k] / top, slope = (y[k + 1] - y[k]) / top / width;
            fz_real root = first + fz_root(first * first + 2 * slope * rest), step = width;
            if (root > 0 && 2 * rest / root < width)
                step = 2 * rest / root;
            f->at = u[k] + (top > 0 && root > 0 ? step : FZ_R(0));
            f->found = 1;
        }
        f->done += size;
    }
    if (f->again)
        return;
"""
ROOT = """\
/* Newton's method from above, so that no library is needed. */
static fz_real fz_root(fz_real value)
{
    fz_real root = value > 1 ? value : FZ_R(1), last;
    if (!(value > 0))
        return 0;
    do {
        last = root;
        root = (root + value / root) / 2;
    } while (root < last);
    return last;
}
"""
MAXIMA_FIELDS = """\
    fz_real level, low, high, length, turn, sum; /* second pass: the highest places */
    unsigned long count;
    int again;
"""
MAXIMA = """\
    for (k = 0; f->again && k < n; ++k) {
        if (y[k] < f->level)
            continue;
        if (f->count == 0 || u[k] != f->high) {
            ++f->count;
            f->sum += u[k];
        }
        f->low = f->count == 1 || u[k] < f->low ? u[k] : f->low;
        f->high = f->count == 1 || u[k] > f->high ? u[k] : f->high;
        if (k + 1 < n && y[k + 1] >= f->level) {
            fz_real width = u[k + 1] - u[k];
            f->length += width;
            f->turn += width * (u[k] + width / 2);
        }
    }
    if (f->again)
        return;
"""
LEVEL = "#define FZ_LEVEL (sizeof(fz_real) > 4 ? FZ_R(1.0 - 1e-12) : FZ_R(1.0 - 1e-6)) /* as high as the peak */\n"

SINGLETONS = {
    "centroid": """\
static fz_real fz_of_singletons(const fz_real *u, const fz_real *h, int n)
{
    fz_real total = 0, moment = 0;
    int k;
    for (k = 0; k < n; ++k) {
        total += h[k];
        moment += h[k] * u[k];
    }
    return moment / total;
}
""",
    "bisector": """\
/* The least place such that the heights up to it make half of all. */
static fz_real fz_of_singletons(const fz_real *u, const fz_real *h, int n)
{
    fz_real total = 0, best = 0, below;
    int k, j, found = 0;
    for (k = 0; k < n; ++k)
        total += h[k];
    for (k = 0; k < n; ++k) {
        for (below = 0, j = 0; j < n; ++j)
            below += u[j] <= u[k] ? h[j] : FZ_R(0);
        if (h[k] > 0 && below >= total / 2 && (!found || u[k] < best)) {
            best = u[k];
            found = 1;
        }
    }
    return best;
}
""",
    "maxima": """\
static fz_real fz_of_singletons(const fz_real *u, const fz_real *h, int n)
{
    fz_real top = 0, low = 0, high = 0, sum = 0;
    int k, count = 0;
    for (k = 0; k < n; ++k)
        top = h[k] > top ? h[k] : top;
    for (k = 0; k < n; ++k) {
        if (h[k] < top * FZ_LEVEL)
            continue;
        low = count == 0 || u[k] < low ? u[k] : low;
        high = count == 0 || u[k] > high ? u[k] : high;
        sum += u[k];
        ++count;
    }
    (void)low, (void)high, (void)sum;
    return @PICK@;
}
""",
}
PICK = {"som": "low", "lom": "high", "mom": "sum / count"}
