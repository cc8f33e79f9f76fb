/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The calls of Embree 4 that libgnurt answers, restated from its documented interface: names, numbers and layouts are those of
 * Embree 4.4 as it is built by default (one level of instances in a hit, arrays of instances). Programs that have Embree's own
 * headers need not have this one: the library takes the place of libembree4.so.4 as it is. docs/reference/c-rays.md says what differs.
 *
 * Additional permission under section 7 of the GNU General Public License, version 3: including this header, unmodified, in the
 * source of any work, and compiling the types, constants, macros and inline functions that it defines into that work, does not by
 * itself cause the work to be covered by the GNU General Public License. The library libgnurt itself remains covered by it.
 */
#ifndef GNURT_EMBREE_H
#define GNURT_EMBREE_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

#ifdef __cplusplus
#define GNURT_OPTIONAL = NULL
extern "C" {
#else
#define GNURT_OPTIONAL
#endif

#define GNURT_ALIGN(n) __attribute__((aligned(n)))
#define RTC_INVALID_GEOMETRY_ID ((unsigned int)-1)
#define RTC_MAX_INSTANCE_LEVEL_COUNT 1

typedef struct RTCDeviceTy *RTCDevice;
typedef struct RTCSceneTy *RTCScene;
typedef struct RTCSceneTy *RTCTraversable;
typedef struct RTCGeometryTy *RTCGeometry;
typedef struct RTCBufferTy *RTCBuffer;

enum RTCError {
    RTC_ERROR_NONE = 0,
    RTC_ERROR_UNKNOWN = 1,
    RTC_ERROR_INVALID_ARGUMENT = 2,
    RTC_ERROR_INVALID_OPERATION = 3,
    RTC_ERROR_OUT_OF_MEMORY = 4,
    RTC_ERROR_UNSUPPORTED_CPU = 5,
    RTC_ERROR_CANCELLED = 6
};

/* Those that have a value other than 0 here, and the version. */
enum RTCDeviceProperty {
    RTC_DEVICE_PROPERTY_VERSION = 0,
    RTC_DEVICE_PROPERTY_VERSION_MAJOR = 1,
    RTC_DEVICE_PROPERTY_VERSION_MINOR = 2,
    RTC_DEVICE_PROPERTY_VERSION_PATCH = 3,
    RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED = 32,
    RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED = 33,
    RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED = 34,
    RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED = 64,
    RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED = 66,
    RTC_DEVICE_PROPERTY_IGNORE_INVALID_RAYS_ENABLED = 67,
    RTC_DEVICE_PROPERTY_TRIANGLE_GEOMETRY_SUPPORTED = 96,
    RTC_DEVICE_PROPERTY_QUAD_GEOMETRY_SUPPORTED = 97,
    RTC_DEVICE_PROPERTY_SUBDIVISION_GEOMETRY_SUPPORTED = 98,
    RTC_DEVICE_PROPERTY_CURVE_GEOMETRY_SUPPORTED = 99,
    RTC_DEVICE_PROPERTY_USER_GEOMETRY_SUPPORTED = 100,
    RTC_DEVICE_PROPERTY_POINT_GEOMETRY_SUPPORTED = 101,
    RTC_DEVICE_PROPERTY_JOIN_COMMIT_SUPPORTED = 129,
    RTC_DEVICE_PROPERTY_PARALLEL_COMMIT_SUPPORTED = 130,
    RTC_DEVICE_PROPERTY_CPU_DEVICE = 140
};

enum RTCGeometryType {
    RTC_GEOMETRY_TYPE_TRIANGLE = 0,
    RTC_GEOMETRY_TYPE_QUAD = 1,
    RTC_GEOMETRY_TYPE_GRID = 2,
    RTC_GEOMETRY_TYPE_SUBDIVISION = 8,
    RTC_GEOMETRY_TYPE_CONE_LINEAR_CURVE = 15,
    RTC_GEOMETRY_TYPE_ROUND_LINEAR_CURVE = 16,
    RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE = 17,
    RTC_GEOMETRY_TYPE_ROUND_BEZIER_CURVE = 24,
    RTC_GEOMETRY_TYPE_FLAT_BEZIER_CURVE = 25,
    RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_BEZIER_CURVE = 26,
    RTC_GEOMETRY_TYPE_ROUND_BSPLINE_CURVE = 32,
    RTC_GEOMETRY_TYPE_FLAT_BSPLINE_CURVE = 33,
    RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_BSPLINE_CURVE = 34,
    RTC_GEOMETRY_TYPE_ROUND_HERMITE_CURVE = 40,
    RTC_GEOMETRY_TYPE_FLAT_HERMITE_CURVE = 41,
    RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_HERMITE_CURVE = 42,
    RTC_GEOMETRY_TYPE_SPHERE_POINT = 50,
    RTC_GEOMETRY_TYPE_DISC_POINT = 51,
    RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT = 52,
    RTC_GEOMETRY_TYPE_ROUND_CATMULL_ROM_CURVE = 58,
    RTC_GEOMETRY_TYPE_FLAT_CATMULL_ROM_CURVE = 59,
    RTC_GEOMETRY_TYPE_NORMAL_ORIENTED_CATMULL_ROM_CURVE = 60,
    RTC_GEOMETRY_TYPE_USER = 120,
    RTC_GEOMETRY_TYPE_INSTANCE = 121,
    RTC_GEOMETRY_TYPE_INSTANCE_ARRAY = 122
};

enum RTCBufferType {
    RTC_BUFFER_TYPE_INDEX = 0,
    RTC_BUFFER_TYPE_VERTEX = 1,
    RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE = 2,
    RTC_BUFFER_TYPE_NORMAL = 3,
    RTC_BUFFER_TYPE_TANGENT = 4,
    RTC_BUFFER_TYPE_NORMAL_DERIVATIVE = 5,
    RTC_BUFFER_TYPE_GRID = 8,
    RTC_BUFFER_TYPE_FACE = 16,
    RTC_BUFFER_TYPE_LEVEL = 17,
    RTC_BUFFER_TYPE_EDGE_CREASE_INDEX = 18,
    RTC_BUFFER_TYPE_EDGE_CREASE_WEIGHT = 19,
    RTC_BUFFER_TYPE_VERTEX_CREASE_INDEX = 20,
    RTC_BUFFER_TYPE_VERTEX_CREASE_WEIGHT = 21,
    RTC_BUFFER_TYPE_HOLE = 22,
    RTC_BUFFER_TYPE_TRANSFORM = 23,
    RTC_BUFFER_TYPE_FLAGS = 32
};

/* Rows of RTC_BUFFER_TYPE_GRID: sizes are those of vertices. */
struct RTCGrid {
    unsigned int startVertexID, stride;
    unsigned short width, height;
};

/* The boundary of a subdivision surface is not shown, smooth, smooth with fixed corners, fixed; or all is flat. */
enum RTCSubdivisionMode {
    RTC_SUBDIVISION_MODE_NO_BOUNDARY = 0,
    RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY = 1,
    RTC_SUBDIVISION_MODE_PIN_CORNERS = 2,
    RTC_SUBDIVISION_MODE_PIN_BOUNDARY = 3,
    RTC_SUBDIVISION_MODE_PIN_ALL = 4
};

/* Bits of the rows of RTC_BUFFER_TYPE_FLAGS. */
enum RTCCurveFlags { RTC_CURVE_FLAG_NEIGHBOR_LEFT = 1, RTC_CURVE_FLAG_NEIGHBOR_RIGHT = 2 };

enum RTCFormat {
    RTC_FORMAT_UCHAR = 0x1001,
    RTC_FORMAT_UINT = 0x5001,
    RTC_FORMAT_UINT2 = 0x5002,
    RTC_FORMAT_UINT3 = 0x5003,
    RTC_FORMAT_UINT4 = 0x5004,
    RTC_FORMAT_FLOAT = 0x9001,
    RTC_FORMAT_FLOAT2 = 0x9002,
    RTC_FORMAT_FLOAT3 = 0x9003,
    RTC_FORMAT_FLOAT4 = 0x9004,
    RTC_FORMAT_FLOAT16 = 0x9010,
    RTC_FORMAT_FLOAT3X4_ROW_MAJOR = 0x9134,
    RTC_FORMAT_FLOAT4X4_ROW_MAJOR = 0x9144,
    RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR = 0x9234,
    RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR = 0x9244,
    RTC_FORMAT_GRID = 0xA001,
    RTC_FORMAT_QUATERNION_DECOMPOSITION = 0xB001
};

enum RTCBuildQuality {
    RTC_BUILD_QUALITY_LOW = 0,
    RTC_BUILD_QUALITY_MEDIUM = 1,
    RTC_BUILD_QUALITY_HIGH = 2,
    RTC_BUILD_QUALITY_REFIT = 3
};

enum RTCSceneFlags {
    RTC_SCENE_FLAG_NONE = 0,
    RTC_SCENE_FLAG_DYNAMIC = 1,
    RTC_SCENE_FLAG_COMPACT = 2,
    RTC_SCENE_FLAG_ROBUST = 4,
    RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS = 8
};

enum RTCRayQueryFlags {
    RTC_RAY_QUERY_FLAG_NONE = 0,
    RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER = 2,
    RTC_RAY_QUERY_FLAG_INCOHERENT = 0,
    RTC_RAY_QUERY_FLAG_COHERENT = 0x10000
};

enum RTCFeatureFlags { RTC_FEATURE_FLAG_NONE = 0, RTC_FEATURE_FLAG_ALL = -1 };

/* Rows of rays and hits; a packet has N values in each. */
#define GNURT_RAY_ROWS(row)                                                                                            \
    float row(org_x), row(org_y), row(org_z), row(tnear), row(dir_x), row(dir_y), row(dir_z), row(time), row(tfar);   \
    unsigned int row(mask), row(id), row(flags);
#define GNURT_HIT_ROWS(row, ids)                                                                                       \
    float row(Ng_x), row(Ng_y), row(Ng_z), row(u), row(v);                                                            \
    unsigned int row(primID), row(geomID), ids(instID), ids(instPrimID);
#define GNURT_PACKET(size, n, row, ids)                                                                                \
    struct GNURT_ALIGN(size) RTCRay##n { GNURT_RAY_ROWS(row) };                                                       \
    struct GNURT_ALIGN(size) RTCHit##n { GNURT_HIT_ROWS(row, ids) };                                                  \
    struct RTCRayHit##n { struct RTCRay##n ray; struct RTCHit##n hit; };
#define GNURT_ONE(name) name
#define GNURT_ONE_ID(name) name[1]
#define GNURT_FOUR(name) name[4]
#define GNURT_FOUR_IDS(name) name[1][4]
#define GNURT_EIGHT(name) name[8]
#define GNURT_EIGHT_IDS(name) name[1][8]
#define GNURT_SIXTEEN(name) name[16]
#define GNURT_SIXTEEN_IDS(name) name[1][16]
GNURT_PACKET(16, , GNURT_ONE, GNURT_ONE_ID)
GNURT_PACKET(16, 4, GNURT_FOUR, GNURT_FOUR_IDS)
GNURT_PACKET(32, 8, GNURT_EIGHT, GNURT_EIGHT_IDS)
GNURT_PACKET(64, 16, GNURT_SIXTEEN, GNURT_SIXTEEN_IDS)

/* What callbacks get: packets as large as the call's, RTCRay, RTCHit, RTCRayHit of 1, 4, 8 or 16 lanes, of which one counts. */
struct RTCRayN;
struct RTCHitN;
struct RTCRayHitN;

struct RTCRayQueryContext {
    unsigned int instID[1];
    unsigned int instPrimID[1];
};

static inline void rtcInitRayQueryContext(struct RTCRayQueryContext *context)
{
    context->instID[0] = context->instPrimID[0] = RTC_INVALID_GEOMETRY_ID;
}

struct RTCFilterFunctionNArguments {
    int *valid; /* of each lane: -1 where it counts; 0 rejects the hit */
    void *geometryUserPtr;
    struct RTCRayQueryContext *context;
    struct RTCRayN *ray;
    struct RTCHitN *hit;
    unsigned int N; /* lanes */
};

struct RTCIntersectFunctionNArguments {
    int *valid;
    void *geometryUserPtr;
    unsigned int primID;
    struct RTCRayQueryContext *context;
    struct RTCRayHitN *rayhit;
    unsigned int N; /* lanes */
    unsigned int geomID;
};

struct RTCOccludedFunctionNArguments {
    int *valid;
    void *geometryUserPtr;
    unsigned int primID;
    struct RTCRayQueryContext *context;
    struct RTCRayN *ray;
    unsigned int N; /* lanes */
    unsigned int geomID;
};

struct GNURT_ALIGN(16) RTCBounds {
    float lower_x, lower_y, lower_z, align0;
    float upper_x, upper_y, upper_z, align1;
};

struct GNURT_ALIGN(16) RTCLinearBounds {
    struct RTCBounds bounds0, bounds1;
};

struct RTCBoundsFunctionArguments {
    void *geometryUserPtr;
    unsigned int primID;
    unsigned int timeStep;
    struct RTCBounds *bounds_o;
};

struct RTCDisplacementFunctionNArguments {
    void *geometryUserPtr;
    RTCGeometry geometry;
    unsigned int primID;
    unsigned int timeStep;
    const float *u, *v, *Ng_x, *Ng_y, *Ng_z;
    float *P_x, *P_y, *P_z; /* to be moved */
    unsigned int N;
};

struct GNURT_ALIGN(16) RTCPointQuery {
    float x, y, z, time, radius;
};

struct GNURT_ALIGN(16) RTCPointQueryContext {
    float world2inst[1][16];
    float inst2world[1][16];
    unsigned int instID[1];
    unsigned int instPrimID[1];
    unsigned int instStackSize;
};

static inline void rtcInitPointQueryContext(struct RTCPointQueryContext *context)
{
    context->instStackSize = 0;
    context->instID[0] = context->instPrimID[0] = RTC_INVALID_GEOMETRY_ID;
}

struct GNURT_ALIGN(16) RTCPointQueryFunctionArguments {
    struct RTCPointQuery *query;
    void *userPtr;
    unsigned int primID, geomID;
    struct RTCPointQueryContext *context;
    float similarityScale;
};

struct GNURT_ALIGN(16) RTCQuaternionDecomposition {
    float scale_x, scale_y, scale_z;
    float skew_xy, skew_xz, skew_yz;
    float shift_x, shift_y, shift_z;
    float quaternion_r, quaternion_i, quaternion_j, quaternion_k;
    float translation_x, translation_y, translation_z;
};

typedef void (*RTCErrorFunction)(void *user, enum RTCError code, const char *message);
typedef bool (*RTCMemoryMonitorFunction)(void *user, ssize_t bytes, bool post);
typedef bool (*RTCProgressMonitorFunction)(void *user, double done);
typedef void (*RTCFilterFunctionN)(const struct RTCFilterFunctionNArguments *);
typedef void (*RTCDisplacementFunctionN)(const struct RTCDisplacementFunctionNArguments *);
typedef void (*RTCIntersectFunctionN)(const struct RTCIntersectFunctionNArguments *);
typedef void (*RTCOccludedFunctionN)(const struct RTCOccludedFunctionNArguments *);
typedef void (*RTCBoundsFunction)(const struct RTCBoundsFunctionArguments *);
/* Primitives of the first scene and of the second that may meet. */
struct RTCCollision {
    unsigned int geomID0, primID0, geomID1, primID1;
};

typedef void (*RTCCollideFunc)(void *user, struct RTCCollision *, unsigned int count);
typedef bool (*RTCPointQueryFunction)(struct RTCPointQueryFunctionArguments *);

struct RTCIntersectArguments {
    enum RTCRayQueryFlags flags;
    enum RTCFeatureFlags feature_mask; /* takes no effect */
    struct RTCRayQueryContext *context;
    RTCFilterFunctionN filter;
    RTCIntersectFunctionN intersect;
};

struct RTCOccludedArguments {
    enum RTCRayQueryFlags flags;
    enum RTCFeatureFlags feature_mask;
    struct RTCRayQueryContext *context;
    RTCFilterFunctionN filter;
    RTCOccludedFunctionN occluded;
};

static inline void rtcInitIntersectArguments(struct RTCIntersectArguments *arguments)
{
    struct RTCIntersectArguments none = { RTC_RAY_QUERY_FLAG_NONE, RTC_FEATURE_FLAG_ALL, NULL, NULL, NULL };
    *arguments = none;
}

static inline void rtcInitOccludedArguments(struct RTCOccludedArguments *arguments)
{
    struct RTCOccludedArguments none = { RTC_RAY_QUERY_FLAG_NONE, RTC_FEATURE_FLAG_ALL, NULL, NULL, NULL };
    *arguments = none;
}

struct RTCInterpolateArguments {
    RTCGeometry geometry;
    unsigned int primID;
    float u, v;
    enum RTCBufferType bufferType;
    unsigned int bufferSlot;
    float *P, *dPdu, *dPdv, *ddPdudu, *ddPdvdv, *ddPdudv; /* each may be null */
    unsigned int valueCount;
};

struct RTCInterpolateNArguments {
    RTCGeometry geometry;
    const void *valid; /* ints, or null for all */
    const unsigned int *primIDs;
    const float *u, *v;
    unsigned int N;
    enum RTCBufferType bufferType;
    unsigned int bufferSlot;
    float *P, *dPdu, *dPdv, *ddPdudu, *ddPdvdv, *ddPdudv; /* value k of point i is number k * N + i */
    unsigned int valueCount;
};

/* Devices */
RTCDevice rtcNewDevice(const char *settings);
void rtcRetainDevice(RTCDevice);
void rtcReleaseDevice(RTCDevice);
ssize_t rtcGetDeviceProperty(RTCDevice, enum RTCDeviceProperty);
void rtcSetDeviceProperty(RTCDevice, enum RTCDeviceProperty, ssize_t);
enum RTCError rtcGetDeviceError(RTCDevice);
const char *rtcGetDeviceLastErrorMessage(RTCDevice);
const char *rtcGetErrorString(enum RTCError);
void rtcSetDeviceErrorFunction(RTCDevice, RTCErrorFunction, void *user);
void rtcSetDeviceMemoryMonitorFunction(RTCDevice, RTCMemoryMonitorFunction, void *user);

/* Buffers */
RTCBuffer rtcNewBuffer(RTCDevice, size_t bytes);
RTCBuffer rtcNewSharedBuffer(RTCDevice, void *start, size_t bytes);
void *rtcGetBufferData(RTCBuffer);
void rtcRetainBuffer(RTCBuffer);
void rtcReleaseBuffer(RTCBuffer);

/* Geometries */
RTCGeometry rtcNewGeometry(RTCDevice, enum RTCGeometryType);
void rtcRetainGeometry(RTCGeometry);
void rtcReleaseGeometry(RTCGeometry);
void rtcCommitGeometry(RTCGeometry);
void rtcEnableGeometry(RTCGeometry);
void rtcDisableGeometry(RTCGeometry);
void rtcSetGeometryTessellationRate(RTCGeometry, float rate);
void rtcSetGeometryTimeStepCount(RTCGeometry, unsigned int count);
void rtcSetGeometryTimeRange(RTCGeometry, float start, float end);
void rtcSetGeometryVertexAttributeCount(RTCGeometry, unsigned int count);
void rtcSetGeometryMask(RTCGeometry, unsigned int mask);
void rtcSetGeometryBuildQuality(RTCGeometry, enum RTCBuildQuality);
void rtcSetGeometryMaxRadiusScale(RTCGeometry, float scale);
void rtcSetGeometryBuffer(RTCGeometry, enum RTCBufferType, unsigned int slot, enum RTCFormat, RTCBuffer, size_t offset,
                          size_t stride, size_t count);
void rtcSetSharedGeometryBuffer(RTCGeometry, enum RTCBufferType, unsigned int slot, enum RTCFormat, const void *start,
                                size_t offset, size_t stride, size_t count);
void *rtcSetNewGeometryBuffer(RTCGeometry, enum RTCBufferType, unsigned int slot, enum RTCFormat, size_t stride,
                              size_t count);
void *rtcGetGeometryBufferData(RTCGeometry, enum RTCBufferType, unsigned int slot);
void rtcUpdateGeometryBuffer(RTCGeometry, enum RTCBufferType, unsigned int slot);
void rtcSetGeometryIntersectFilterFunction(RTCGeometry, RTCFilterFunctionN);
void rtcSetGeometryOccludedFilterFunction(RTCGeometry, RTCFilterFunctionN);
void rtcSetGeometryEnableFilterFunctionFromArguments(RTCGeometry, bool enable);
void rtcSetGeometryUserData(RTCGeometry, void *pointer);
void *rtcGetGeometryUserData(RTCGeometry);
void rtcSetGeometryPointQueryFunction(RTCGeometry, RTCPointQueryFunction);
void rtcSetGeometryUserPrimitiveCount(RTCGeometry, unsigned int count);
void rtcSetGeometryBoundsFunction(RTCGeometry, RTCBoundsFunction, void *user);
void rtcSetGeometryIntersectFunction(RTCGeometry, RTCIntersectFunctionN);
void rtcSetGeometryOccludedFunction(RTCGeometry, RTCOccludedFunctionN);
void rtcInvokeIntersectFilterFromGeometry(const struct RTCIntersectFunctionNArguments *,
                                          const struct RTCFilterFunctionNArguments *);
void rtcInvokeOccludedFilterFromGeometry(const struct RTCOccludedFunctionNArguments *,
                                         const struct RTCFilterFunctionNArguments *);
void rtcSetGeometryInstancedScene(RTCGeometry, RTCScene);
void rtcSetGeometryInstancedScenes(RTCGeometry, RTCScene *scenes, size_t count);
void rtcSetGeometryTransform(RTCGeometry, unsigned int time_step, enum RTCFormat, const void *matrix);
void rtcSetGeometryTransformQuaternion(RTCGeometry, unsigned int time_step, const struct RTCQuaternionDecomposition *);
void rtcGetGeometryTransform(RTCGeometry, float time, enum RTCFormat, void *matrix);
void rtcGetGeometryTransformEx(RTCGeometry, unsigned int instance, float time, enum RTCFormat, void *matrix);
void rtcInterpolate(const struct RTCInterpolateArguments *);
void rtcInterpolateN(const struct RTCInterpolateNArguments *);
void rtcSetGeometryTopologyCount(RTCGeometry, unsigned int count);
void rtcSetGeometrySubdivisionMode(RTCGeometry, unsigned int topology, enum RTCSubdivisionMode);
void rtcSetGeometryVertexAttributeTopology(RTCGeometry, unsigned int attribute, unsigned int topology);
void rtcSetGeometryDisplacementFunction(RTCGeometry, RTCDisplacementFunctionN);
unsigned int rtcGetGeometryFirstHalfEdge(RTCGeometry, unsigned int face);
unsigned int rtcGetGeometryFace(RTCGeometry, unsigned int edge);
unsigned int rtcGetGeometryNextHalfEdge(RTCGeometry, unsigned int edge);
unsigned int rtcGetGeometryPreviousHalfEdge(RTCGeometry, unsigned int edge);
unsigned int rtcGetGeometryOppositeHalfEdge(RTCGeometry, unsigned int topology, unsigned int edge);

/* Scenes */
RTCScene rtcNewScene(RTCDevice);
RTCDevice rtcGetSceneDevice(RTCScene);
void rtcRetainScene(RTCScene);
void rtcReleaseScene(RTCScene);
RTCTraversable rtcGetSceneTraversable(RTCScene);
unsigned int rtcAttachGeometry(RTCScene, RTCGeometry);
void rtcAttachGeometryByID(RTCScene, RTCGeometry, unsigned int id);
void rtcDetachGeometry(RTCScene, unsigned int id);
RTCGeometry rtcGetGeometry(RTCScene, unsigned int id);
RTCGeometry rtcGetGeometryThreadSafe(RTCScene, unsigned int id);
void rtcCommitScene(RTCScene);     /* nothing happens where nothing was edited */
void rtcJoinCommitScene(RTCScene); /* of several threads: one builds, the others return when it is done */
void rtcSetSceneProgressMonitorFunction(RTCScene, RTCProgressMonitorFunction, void *user);
void rtcSetSceneBuildQuality(RTCScene, enum RTCBuildQuality);
void rtcSetSceneFlags(RTCScene, enum RTCSceneFlags);
enum RTCSceneFlags rtcGetSceneFlags(RTCScene);
void rtcGetSceneBounds(RTCScene, struct RTCBounds *);
void rtcGetSceneLinearBounds(RTCScene, struct RTCLinearBounds *);
void *rtcGetGeometryUserDataFromScene(RTCScene, unsigned int id);
void rtcGetGeometryTransformFromScene(RTCScene, unsigned int id, float time, enum RTCFormat, void *matrix);

/* Queries; of packets, rays with a valid that is not 0 are traced */
void rtcIntersect1(RTCScene, struct RTCRayHit *, struct RTCIntersectArguments * GNURT_OPTIONAL);
void rtcIntersect4(const int *valid, RTCScene, struct RTCRayHit4 *, struct RTCIntersectArguments * GNURT_OPTIONAL);
void rtcIntersect8(const int *valid, RTCScene, struct RTCRayHit8 *, struct RTCIntersectArguments * GNURT_OPTIONAL);
void rtcIntersect16(const int *valid, RTCScene, struct RTCRayHit16 *, struct RTCIntersectArguments * GNURT_OPTIONAL);
void rtcOccluded1(RTCScene, struct RTCRay *, struct RTCOccludedArguments * GNURT_OPTIONAL);
void rtcOccluded4(const int *valid, RTCScene, struct RTCRay4 *, struct RTCOccludedArguments * GNURT_OPTIONAL);
void rtcOccluded8(const int *valid, RTCScene, struct RTCRay8 *, struct RTCOccludedArguments * GNURT_OPTIONAL);
void rtcOccluded16(const int *valid, RTCScene, struct RTCRay16 *, struct RTCOccludedArguments * GNURT_OPTIONAL);
void rtcForwardIntersect1(const struct RTCIntersectFunctionNArguments *, RTCScene, struct RTCRay *, unsigned int instID);
void rtcForwardIntersect1Ex(const struct RTCIntersectFunctionNArguments *, RTCScene, struct RTCRay *,
                            unsigned int instID, unsigned int instPrimID);
void rtcForwardOccluded1(const struct RTCOccludedFunctionNArguments *, RTCScene, struct RTCRay *, unsigned int instID);
void rtcForwardOccluded1Ex(const struct RTCOccludedFunctionNArguments *, RTCScene, struct RTCRay *, unsigned int instID,
                           unsigned int instPrimID);
/* From the test of a user geometry; of packets, N of the test's arguments says which */
void rtcForwardIntersect4(const int *valid, const struct RTCIntersectFunctionNArguments *, RTCScene, struct RTCRay4 *,
                       unsigned int instID);
void rtcForwardIntersect4Ex(const int *valid, const struct RTCIntersectFunctionNArguments *, RTCScene, struct RTCRay4 *,
                         unsigned int instID, unsigned int instPrimID);
void rtcForwardIntersect8(const int *valid, const struct RTCIntersectFunctionNArguments *, RTCScene, struct RTCRay8 *,
                       unsigned int instID);
void rtcForwardIntersect8Ex(const int *valid, const struct RTCIntersectFunctionNArguments *, RTCScene, struct RTCRay8 *,
                         unsigned int instID, unsigned int instPrimID);
void rtcForwardIntersect16(const int *valid, const struct RTCIntersectFunctionNArguments *, RTCScene, struct RTCRay16 *,
                       unsigned int instID);
void rtcForwardIntersect16Ex(const int *valid, const struct RTCIntersectFunctionNArguments *, RTCScene, struct RTCRay16 *,
                         unsigned int instID, unsigned int instPrimID);
void rtcForwardOccluded4(const int *valid, const struct RTCOccludedFunctionNArguments *, RTCScene, struct RTCRay4 *,
                       unsigned int instID);
void rtcForwardOccluded4Ex(const int *valid, const struct RTCOccludedFunctionNArguments *, RTCScene, struct RTCRay4 *,
                         unsigned int instID, unsigned int instPrimID);
void rtcForwardOccluded8(const int *valid, const struct RTCOccludedFunctionNArguments *, RTCScene, struct RTCRay8 *,
                       unsigned int instID);
void rtcForwardOccluded8Ex(const int *valid, const struct RTCOccludedFunctionNArguments *, RTCScene, struct RTCRay8 *,
                         unsigned int instID, unsigned int instPrimID);
void rtcForwardOccluded16(const int *valid, const struct RTCOccludedFunctionNArguments *, RTCScene, struct RTCRay16 *,
                       unsigned int instID);
void rtcForwardOccluded16Ex(const int *valid, const struct RTCOccludedFunctionNArguments *, RTCScene, struct RTCRay16 *,
                         unsigned int instID, unsigned int instPrimID);
void rtcCollide(RTCScene, RTCScene, RTCCollideFunc, void *user); /* all pairs, in blocks, by the calling thread */
bool rtcPointQuery(RTCScene, struct RTCPointQuery *, struct RTCPointQueryContext *, RTCPointQueryFunction, void *user);
void rtcTraversableIntersect1(RTCTraversable, struct RTCRayHit *, struct RTCIntersectArguments * GNURT_OPTIONAL);
void rtcTraversableOccluded1(RTCTraversable, struct RTCRay *, struct RTCOccludedArguments * GNURT_OPTIONAL);

/* Hierarchies of the program's own: one thread calls its functions; no primitive is split */
typedef struct RTCBVHTy *RTCBVH;
typedef struct RTCThreadLocalAllocatorTy *RTCThreadLocalAllocator;

struct GNURT_ALIGN(32) RTCBuildPrimitive {
    float lower_x, lower_y, lower_z;
    unsigned int geomID;
    float upper_x, upper_y, upper_z;
    unsigned int primID;
};

typedef void *(*RTCCreateNodeFunction)(RTCThreadLocalAllocator, unsigned int children, void *user);
typedef void (*RTCSetNodeChildrenFunction)(void *node, void **children, unsigned int count, void *user);
typedef void (*RTCSetNodeBoundsFunction)(void *node, const struct RTCBounds **, unsigned int count, void *user);
typedef void *(*RTCCreateLeafFunction)(RTCThreadLocalAllocator, const struct RTCBuildPrimitive *, size_t count, void *user);
typedef void (*RTCSplitPrimitiveFunction)(const struct RTCBuildPrimitive *, unsigned int dimension, float position,
                                          struct RTCBounds *left, struct RTCBounds *right, void *user);

enum RTCBuildFlags { RTC_BUILD_FLAG_NONE = 0, RTC_BUILD_FLAG_DYNAMIC = 1 };
enum RTCBuildConstants { RTC_BUILD_MAX_PRIMITIVES_PER_LEAF = 32 };

struct RTCBuildArguments {
    size_t byteSize;
    enum RTCBuildQuality buildQuality; /* takes no effect, as the flags */
    enum RTCBuildFlags buildFlags;
    unsigned int maxBranchingFactor, maxDepth, sahBlockSize, minLeafSize, maxLeafSize;
    float traversalCost, intersectionCost;
    RTCBVH bvh;
    struct RTCBuildPrimitive *primitives; /* in another order afterwards */
    size_t primitiveCount, primitiveArrayCapacity;
    RTCCreateNodeFunction createNode;
    RTCSetNodeChildrenFunction setNodeChildren;
    RTCSetNodeBoundsFunction setNodeBounds;
    RTCCreateLeafFunction createLeaf;
    RTCSplitPrimitiveFunction splitPrimitive; /* is not called */
    RTCProgressMonitorFunction buildProgress;
    void *userPtr;
};

static inline struct RTCBuildArguments rtcDefaultBuildArguments(void)
{
    struct RTCBuildArguments arguments = { sizeof(struct RTCBuildArguments), RTC_BUILD_QUALITY_MEDIUM, RTC_BUILD_FLAG_NONE, 2, 32, 1,
                                           1, RTC_BUILD_MAX_PRIMITIVES_PER_LEAF, 1, 1, NULL, NULL, 0, 0, NULL, NULL, NULL, NULL,
                                           NULL, NULL, NULL };
    return arguments;
}

RTCBVH rtcNewBVH(RTCDevice);
void *rtcBuildBVH(const struct RTCBuildArguments *);
void *rtcThreadLocalAlloc(RTCThreadLocalAllocator, size_t bytes, size_t align);
void rtcRetainBVH(RTCBVH);
void rtcReleaseBVH(RTCBVH);

#ifdef __cplusplus
}
#endif
#endif
