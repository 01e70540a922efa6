// Shoots the rays of `srp watertight --export DIR` with Embree, and writes DIR/embree/MESH.hits and, by its robust mode,
// DIR/embree-robust/MESH.hits: a line for each ray, 1 where it hits.

#include <embree3/rtcore.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

namespace fs = std::filesystem;

struct Ray {
    float origin[3], direction[3];
};

// Triangles of an .obj file of `srp`, whose vertices are no other triangle's.
static std::vector<float> read_mesh(const fs::path& path) {
    std::ifstream in(path);
    std::vector<float> corners;
    std::string line;
    while (std::getline(in, line)) {
        float x, y, z;
        if (std::sscanf(line.c_str(), "v %f %f %f", &x, &y, &z) == 3) {
            corners.insert(corners.end(), {x, y, z});
        }
    }
    return corners;
}

static std::vector<Ray> read_rays(const fs::path& path) {
    std::ifstream in(path);
    std::vector<Ray> rays;
    std::string line;
    while (std::getline(in, line)) {
        Ray ray;
        float* o = ray.origin;
        float* d = ray.direction;
        if (std::sscanf(line.c_str(), "%f %f %f %f %f %f", o, o + 1, o + 2, d, d + 1, d + 2) == 6) {
            rays.push_back(ray);
        }
    }
    return rays;
}

static void shoot(RTCDevice device, const std::vector<float>& corners, const std::vector<Ray>& rays, bool robust,
                  const fs::path& to) {
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    size_t vertices = corners.size() / 3;
    auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                          3 * sizeof(float), vertices));
    std::copy(corners.begin(), corners.end(), v);
    auto* t = static_cast<unsigned*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                             3 * sizeof(unsigned), vertices / 3));
    for (unsigned i = 0; i < vertices; i++) {
        t[i] = i;
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    std::ofstream out(to);
    for (const Ray& ray : rays) {
        RTCRayHit hit = {};
        hit.ray.org_x = ray.origin[0];
        hit.ray.org_y = ray.origin[1];
        hit.ray.org_z = ray.origin[2];
        hit.ray.dir_x = ray.direction[0];
        hit.ray.dir_y = ray.direction[1];
        hit.ray.dir_z = ray.direction[2];
        hit.ray.tfar = std::numeric_limits<float>::infinity();
        hit.ray.mask = ~0u;
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene, &context, &hit);
        out << (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? "0\n" : "1\n");
    }
    rtcReleaseScene(scene);
}

int main(int count, char** arguments) {
    if (count != 2) {
        std::fputs("usage: hits DIR\n", stderr);
        return 2;
    }
    fs::path folder = arguments[1];
    RTCDevice device = rtcNewDevice("threads=1");
    for (bool robust : {false, true}) {
        fs::create_directories(folder / (robust ? "embree-robust" : "embree"));
    }
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (entry.path().extension() != ".obj") {
            continue;
        }
        std::string name = entry.path().stem().string();
        auto corners = read_mesh(entry.path());
        auto rays = read_rays(folder / (name + ".rays"));
        shoot(device, corners, rays, false, folder / "embree" / (name + ".hits"));
        shoot(device, corners, rays, true, folder / "embree-robust" / (name + ".hits"));
    }
    rtcReleaseDevice(device);
}
