/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Hierarchies that rtcBuildBVH makes of the program's nodes: every box in one leaf, boxes inside of boxes, limits, and a cost well below
 * that of halves. Runs on Embree's own library as well, with an argument: errors are ours. */
#include <gnurt/embree.h>
#include <stdint.h>

#include "check.h"

static RTCDevice device;
static bool is_ours;

enum { MOST = 20000 };
static struct RTCBuildPrimitive given[MOST], boxes[2 * MOST];

struct node {
    unsigned count; /* of children; 0 for a leaf */
    unsigned size;  /* of a leaf */
    struct RTCBounds bounds[16];
    struct node *children[16];
    unsigned ids[32];
};

static unsigned branching, depth, most_leaf;
static int bad;

static void *create_node(RTCThreadLocalAllocator allocator, unsigned count, void *user)
{
    struct node *node = rtcThreadLocalAlloc(allocator, sizeof *node, 64);
    __atomic_fetch_add(&bad, user != given || count < 2 || count > branching || (uintptr_t)node % 64 != 0, __ATOMIC_RELAXED);
    node->count = count;
    return node;
}

static void set_children(void *at, void **children, unsigned count, void *user)
{
    struct node *node = at;
    (void)user;
    __atomic_fetch_add(&bad, node->count != count, __ATOMIC_RELAXED);
    for (unsigned i = 0; i < count; i++)
        node->children[i] = children[i];
}

static void set_bounds(void *at, const struct RTCBounds **bounds, unsigned count, void *user)
{
    struct node *node = at;
    (void)user;
    for (unsigned i = 0; i < count; i++)
        node->bounds[i] = *bounds[i];
}

static void *create_leaf(RTCThreadLocalAllocator allocator, const struct RTCBuildPrimitive *primitives, size_t count, void *user)
{
    struct node *node = rtcThreadLocalAlloc(allocator, sizeof *node, 16);
    (void)user;
    __atomic_fetch_add(&bad, count < 1 || count > most_leaf, __ATOMIC_RELAXED);
    node->count = 0, node->size = (unsigned)count;
    for (size_t i = 0; i < count; i++) {
        node->ids[i] = primitives[i].primID;
        __atomic_fetch_add(&bad, primitives[i].geomID != primitives[i].primID / 100, __ATOMIC_RELAXED);
    }
    return node;
}

static unsigned char seen[MOST];
static unsigned deepest;

static bool is_in(const float *low, const float *high, const struct RTCBounds *bounds)
{
    for (int k = 0; k < 3; k++)
        if (low[k] < (&bounds->lower_x)[k] - 1e-5f || high[k] > (&bounds->upper_x)[k] + 1e-5f)
            return false;
    return true;
}

static double half_area(const float *low, const float *high)
{
    double x = high[0] - low[0], y = high[1] - low[1], z = high[2] - low[2];
    return x * y + y * z + z * x;
}

/* The cost, where boxes are hit as their areas are. */
static double walk(const struct node *node, const struct RTCBounds *around, unsigned level)
{
    deepest = level > deepest ? level : deepest;
    double cost = half_area(&around->lower_x, &around->upper_x) * (node->count ? 1 : node->size);
    if (!node->count)
        for (unsigned i = 0; i < node->size; i++) {
            const struct RTCBuildPrimitive *box = &given[node->ids[i]];
            seen[node->ids[i]]++;
            bad += !is_in(&box->lower_x, &box->upper_x, around);
        }
    for (unsigned i = 0; i < node->count; i++) {
        bad += !is_in(&node->bounds[i].lower_x, &node->bounds[i].upper_x, around);
        cost += walk(node->children[i], &node->bounds[i], level + 1);
    }
    return cost;
}

/* The cost of halves of an array in the order along the longest side. */
static int sorted_by;
static int by_middle(const void *a, const void *b)
{
    const float *p = a, *q = b;
    float x = p[sorted_by] + p[4 + sorted_by], y = q[sorted_by] + q[4 + sorted_by];
    return (x > y) - (x < y);
}

static double halves(struct RTCBuildPrimitive *all, int count)
{
    float low[3] = { INFINITY, INFINITY, INFINITY }, high[3] = { -INFINITY, -INFINITY, -INFINITY };
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            low[k] = fminf(low[k], (&all[i].lower_x)[k]);
            high[k] = fmaxf(high[k], (&all[i].upper_x)[k]);
        }
    if (count <= 2)
        return half_area(low, high) * count;
    sorted_by = high[1] - low[1] > high[0] - low[0];
    if (high[2] - low[2] > high[sorted_by] - low[sorted_by])
        sorted_by = 2;
    qsort(all, count, sizeof *all, by_middle);
    return half_area(low, high) + halves(all, count / 2) + halves(all + count / 2, count - count / 2);
}

static bool stop(void *user, double done)
{
    return user == NULL && done < 0;
}

static struct RTCBuildArguments arguments_of(RTCBVH bvh, int count)
{
    struct RTCBuildArguments args = rtcDefaultBuildArguments();
    args.bvh = bvh, args.primitives = boxes, args.primitiveCount = count, args.primitiveArrayCapacity = 2 * MOST;
    args.createNode = create_node, args.setNodeChildren = set_children, args.setNodeBounds = set_bounds;
    args.createLeaf = create_leaf, args.userPtr = given;
    branching = args.maxBranchingFactor, depth = args.maxDepth, most_leaf = args.maxLeafSize;
    memcpy(boxes, given, sizeof given);
    return args;
}

static void fill(bool is_clustered)
{
    for (int i = 0; i < MOST; i++) {
        given[i].geomID = i / 100, given[i].primID = i;
        for (int k = 0; k < 3; k++) {
            float at = is_clustered ? powf(number(), 6) + (i % 7) * 0.3f * k : 0.5f, size = 0.01f + 0.02f * number();
            (&given[i].lower_x)[k] = at, (&given[i].upper_x)[k] = at + (is_clustered ? size : 0.25f);
        }
    }
}

static void check(RTCBVH bvh, const struct RTCBuildArguments *args, const char *what, bool is_cheap)
{
    int count = (int)args->primitiveCount;
    branching = args->maxBranchingFactor, depth = args->maxDepth, most_leaf = args->maxLeafSize;
    bad = 0, deepest = 0;
    memset(seen, 0, sizeof seen);
    struct node *root = rtcBuildBVH(args);
    CHECK(root != NULL, "%s: a root", what);
    if (!root)
        return;
    struct RTCBounds all = { -INFINITY, -INFINITY, -INFINITY, 0, INFINITY, INFINITY, INFINITY, 0 };
    double cost = 0;
    if (root->count) {
        for (unsigned i = 0; i < root->count; i++)
            cost += walk(root->children[i], &root->bounds[i], 2);
    } else {
        walk(root, &all, 1);
    }
    int times = 0;
    for (int i = 0; i < count; i++)
        times += seen[i] == 1;
    CHECK(bad == 0 && times == count, "%s: %d mistakes, %d of %d boxes once", what, bad, times, count);
    CHECK(deepest <= depth, "%s: %u of %u levels", what, deepest, depth);
    memcpy(boxes, given, sizeof given);
    double simple = halves(boxes, count);
    CHECK(!is_cheap || cost < 0.9 * simple, "%s: cost %g, of halves %g", what, cost, simple);
    (void)bvh;
}

int main(int count, char **values)
{
    (void)values;
    device = rtcNewDevice(NULL);
    is_ours = count == 1;
    RTCBVH bvh = rtcNewBVH(device);
    fill(true);
    struct RTCBuildArguments args = arguments_of(bvh, MOST);
    check(bvh, &args, "pairs", true);
    args = arguments_of(bvh, MOST);
    args.maxBranchingFactor = 8, args.maxLeafSize = 4, args.minLeafSize = 2;
    check(bvh, &args, "eight children", false);
    args = arguments_of(bvh, MOST);
    args.buildQuality = RTC_BUILD_QUALITY_LOW;
    check(bvh, &args, "low quality", false);
    args = arguments_of(bvh, 1);
    check(bvh, &args, "one box", false);
    fill(false);
    args = arguments_of(bvh, 500);
    check(bvh, &args, "boxes in one place", false);
    if (is_ours) {
        fill(true);
        args = arguments_of(bvh, MOST);
        args.maxDepth = 12, args.maxLeafSize = 16;
        check(bvh, &args, "few levels", false);
        CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE, "so far");
        args.maxDepth = 4;
        CHECK(!rtcBuildBVH(&args) && rtcGetDeviceError(device) == RTC_ERROR_INVALID_ARGUMENT, "too few levels");
        args = arguments_of(bvh, MOST);
        args.buildProgress = stop;
        CHECK(!rtcBuildBVH(&args) && rtcGetDeviceError(device) == RTC_ERROR_CANCELLED, "cancelled");
        args = arguments_of(bvh, MOST);
        args.maxBranchingFactor = 1;
        CHECK(!rtcBuildBVH(&args) && rtcGetDeviceError(device) == RTC_ERROR_INVALID_ARGUMENT, "one child");
        args = arguments_of(bvh, MOST);
        args.createLeaf = NULL;
        CHECK(!rtcBuildBVH(&args) && rtcGetDeviceError(device) == RTC_ERROR_INVALID_ARGUMENT, "no function");
        args = arguments_of(bvh, 0);
        CHECK(!rtcBuildBVH(&args) && rtcGetDeviceError(device) == RTC_ERROR_NONE, "nothing");
        args.bvh = NULL;
        CHECK(!rtcBuildBVH(&args) && rtcGetDeviceError(NULL) == RTC_ERROR_INVALID_ARGUMENT, "no BVH");
    }
    rtcRetainBVH(bvh);
    rtcReleaseBVH(bvh);
    rtcReleaseBVH(bvh);
    rtcReleaseDevice(device);
    return finish();
}
