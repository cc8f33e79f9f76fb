#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Renders the pictures of docs/reference/shader-library.md: shaders/pictures.sh [OUT], in the repository's root; OUT is docs/shaders unless given.
# gnurt, python3 and cwebp are on the PATH. SIZE (512) and SPP (64) make them finer or faster; ONLY=name renders one of them.
set -euo pipefail
out=${1:-docs/shaders} size=${SIZE:-512} spp=${SPP:-64}
mkdir -p "$out"
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT

# picture NAME SCENE [OPTION...]
picture() {
    local name=$1 scene=$2
    shift 2
    if [ "${ONLY:-$name}" != "$name" ]; then return; fi
    gnurt render -q "$scene" -o "$work/$name.png" -r "${size}x$size" --spp "$spp" --clamp 8 "$@"
    cwebp -quiet -q 90 -m 6 -sharp_yuv "$work/$name.png" -o "$out/$name.webp"
}

# Surfaces, on the stage; NAME:PARAMETERS, which suit its size.
python3 docs/shaders/stage.py "$work/stage.obj"
for surface in marble:scale=1.5 metal car_paint wood bricks brushed_metal checker concrete fabric:threads=50 frosted_glass lava leather:scale=14 \
    plastic principled:base=0.6,0.1,0.08:coat=1:sheen=0.1,0.1,0.2 rust:scale=2 skin snow tiles velvet water:height=0.08; do
    name=${surface%%:*} parameters=${surface#"$name"}
    picture "$name" "$work/stage.obj" --eye 0,2.0,5.2 --target 0,0.99,0 --fov 28 --environment 0.25,0.26,0.28 --exposure 0 \
        --shader "shown=shaders/surfaces/$name.osl$parameters"
done

# Ground needs heights: hills of 96 by 96 squares, z upwards.
awk 'BEGIN {
    n = 96
    print "o hills\nusemtl ground"
    for (j = 0; j <= n; j++) for (i = 0; i <= n; i++) {
        x = 4 * i / n - 2; y = 4 * j / n - 2
        ridge = sin(3.1 * x + 1.3 * y) * cos(2.3 * y - 0.7 * x) + 0.5 * sin(6.7 * x - 2.9 * y) * cos(5.3 * y)
        print "v", x, y, (2.1 + 0.5 * ridge) * exp(-0.9 * (x * x + y * y)) - 0.06
    }
    for (j = 0; j < n; j++) for (i = 1; i <= n; i++) {
        a = j * (n + 1) + i
        print "f", a, a + 1, a + n + 2, a + n + 1
    }
}' >"$work/hills.obj"
picture terrain "$work/hills.obj" --eye 3.4,-4.4,2.6 --target 0,0,0.75 --up 0,0,1 --fov 36 --environment builtin:day \
    --exposure -0.8 --shader "*=shaders/surfaces/terrain.osl:snow_line=1.5"

# A picture for the projector.
gnurt render -q builtin:island -o "$work/slide.png" -r 320x180 --spp 16

# Lights in the dark, on things of grey plastic.
dim="builtin:spheres --environment 0.02,0.02,0.03 --eye 0.2,2.2,6.2 --target -0.1,0.5,-0.3 --fov 50 --exposure -1 \
    --shader *=shaders/surfaces/plastic.osl:base=0.5:roughness=0.4"
for light in "candle:power=1.5:from=0.35,0.6,1.9:size=0.1" "point_light:intensity=14,13,12:from=1.5,3,2" \
    "projector:picture=$work/slide.png:intensity=70:angle=50:place=1,0,0,0,0,1,0,0,0,0,1,0,0,1.5,5,1" \
    "softbox:radiance_of_it=5:place=2,0,0,0,0,2,0,0,0,0,2,0,1,2.5,3.5,1" \
    "spot_light:intensity=70:from=1.5,4,3:to=-0.2,0.6,-0.3:inner=9:outer=15" "sun:elevation=25:azimuth=70:diameter=3"; do
    name=${light%%:*}
    # shellcheck disable=SC2086
    picture "$name" $dim --shader "shaders/lights/$name.osl${light#"$name"}"
done

# Skies, wide, above the spheres.
for name in gradient_sky night sunset; do
    exposure=0
    if [ "$name" = night ]; then exposure=1; fi
    picture "$name" builtin:spheres --eye 0.4,1.2,6.2 --target -0.1,2.2,-0.3 --fov 70 --exposure $exposure \
        --environment "shaders/skies/$name.osl"
done

# Cameras.
picture pinhole builtin:spheres --camera shaders/cameras/pinhole.osl:fov=36
picture thin_lens builtin:spheres --camera shaders/cameras/thin_lens.osl:fov=36:focus=6:opening=0.25
picture fisheye builtin:spheres --eye 0.4,1.2,3 --camera shaders/cameras/fisheye.osl:fov=200
picture panorama builtin:spheres --eye 0.2,1,2 --camera shaders/cameras/panorama.osl

# Pixel shaders, over what the camera sees.
for pixel in plain:exposure=-0.5 distances:nearest=4:farthest=10 ink; do
    name=${pixel%%:*}
    picture "$name" builtin:spheres --exposure -0.8 --denoise=none --pixel-shader "shaders/pixels/$name.osl${pixel#"$name"}"
done
