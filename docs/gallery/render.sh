#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Renders the gallery: render.sh SCENES WORK OUT. SCENES holds the folders conference, office, ...; gnurt and cwebp are on the PATH.
# HEIGHT (720) and SPP (64) make it finer or faster; ONLY=name renders one picture.
set -euo pipefail
scenes=$1 work=$2 out=$3
height=${HEIGHT:-720} spp=${SPP:-64}
wide=$((height * 16 / 9))x$height square=${height}x$height tall=$((height * 3 / 4))x$height
python3 "$(dirname "$0")/compose.py" "$scenes" "$work"
mkdir -p "$out"

# picture NAME SIZE SCENE [OPTION...]
picture() {
    local name=$1 size=$2 file=$3
    shift 3
    if [ "${ONLY:-$name}" != "$name" ]; then return; fi
    gnurt render -q "$file" -o "$work/$name.png" -r "$size" --spp "$spp" --clamp 8 "$@"
    cwebp -quiet -q 92 -m 6 -sharp_yuv "$work/$name.png" -o "$out/$name.webp"
}

picture bunny "$wide" "$work/bunny.obj" --eye -0.05,0.15,0.35 --target -0.017,0.11,0 --fov 30
picture dragon "$wide" "$work/dragon.obj" --eye -0.06,0.17,0.34 --target -0.006,0.125,-0.005 --fov 30
picture buddha "$tall" "$work/buddha-100k.obj" --eye 0.3,0.3,4.6 --target -0.05,0,0 --fov 27
picture armadillo "$square" "$work/armadillo.obj" --eye 0,0.1,2.6 --target 0,-0.07,0 --fov 30 \
    --spp $((4 * spp))
python3 "$(dirname "$0")/hair.py" "$work/hair.pbrt"
picture hair "${height}x$((height * 9 / 16))" "$work/hair.pbrt" --spp $((9 * spp / 4)) --denoise=none
picture cornell "$square" "$scenes/cornell-box/cornell-box.obj" --eye 0,1,6.8 --target 0,1,0 --fov 19.5
picture office "$wide" "$scenes/office/office.obj" --eye 2.1,3.2,2 --target -1.2,1.9,-0.8 --fov 50
picture conference "$wide" "$scenes/conference/conference.obj" --eye 30,21,7 --target 26.1962,17.9239,5.9663 \
    --up 0,0,1 --fov 36.4
picture modern-hall "$wide" "$scenes/modern-hall/modern-hall.obj" --eye 6.9118,1.6516,2.5541 \
    --target 2.4108,1.6516,0.3766 --fov 43
picture white-room "$wide" "$scenes/white-room/white-room.obj" --eye 2.2501,1.3117,6.1787 \
    --target 0.0791,1.1287,1.6782 --fov 58 --spp $((2 * spp))
picture breakfast-room "$wide" "$scenes/breakfast-room/breakfast-room.obj" --eye -0.5873,2.7623,9.7143 \
    --target -0.5218,2.4428,4.7248 --fov 36 --environment builtin:evening --environment-turn 175 --exposure 4 \
    --spp $((2 * spp))
picture sponza "$wide" "$scenes/sponza/sponza.obj" --eye -12,0,2 --target 12,0,4.5 --up 0,0,1 --fov 60 \
    --environment builtin:day --environment-turn 155
