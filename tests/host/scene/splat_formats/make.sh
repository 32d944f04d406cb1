#!/bin/sh
# Makes all test files from nothing but make.py: needs python3, node 20 or later and npm. Run in the folder of the scripts.
set -e
mkdir -p ../tools
(cd ../tools && npm install --no-audit --no-fund --ignore-scripts @playcanvas/splat-transform@3.7.0 @mkkellogg/gaussian-splats-3d@0.4.7 three@0.187.0)
transform() { node ../tools/node_modules/@playcanvas/splat-transform/bin/cli.mjs -w -q "$@"; }
python3 make.py closed.ply 300
python3 make.py harmonics.ply 40 harmonics
python3 make.py far.ply 12 far
transform closed.ply closed_4.spz
transform closed.ply --spz-version 3 closed_3.spz
transform harmonics.ply harmonics_4.spz
transform far.ply far_4.spz
transform far.ply --spz-version 3 far_3.spz
mkdir -p folder
transform -g cpu closed.ply closed.sog
transform -g cpu closed.ply folder/meta.json
transform closed.ply closed.csv
node make_sog_1.mjs closed.csv folder_1
cp make_ksplat.mjs ../tools/
for level in 0 1 2; do (cd ../tools && node make_ksplat.mjs ../files/closed.ply ../files/closed_$level.ksplat $level 128 40 8 0); done
for level in 1 2; do (cd ../tools && node make_ksplat.mjs ../files/harmonics.ply ../files/harmonics_$level.ksplat $level 0 40 8 1); done
# What splat-transform itself reads of each, for examples/compare.
for file in *.spz *.sog *.ksplat; do transform "$file" "$file.csv"; done
transform folder_1/meta.json folder_1.csv
