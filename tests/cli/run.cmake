# Runs the tool as its users do. Needs BILLOW, MAKE_FILES and FOLDER.
#
# The files that a fixture of the validator looks at are left in FOLDER.
cmake_minimum_required(VERSION 3.22)
file(REMOVE_RECURSE "${FOLDER}")
file(MAKE_DIRECTORY "${FOLDER}")
execute_process(COMMAND "${MAKE_FILES}" "${FOLDER}" RESULT_VARIABLE code)
if(NOT code EQUAL 0)
    message(FATAL_ERROR "the test's files cannot be made")
endif()

# May be called in a function, too.
function(complain text)
    message("FAILED: ${text}")
    set_property(GLOBAL APPEND PROPERTY failures x)
endfunction()

# run(<exit code> <arguments>...) sets out and err.
macro(run expected)
    execute_process(COMMAND "${BILLOW}" ${ARGN} WORKING_DIRECTORY "${FOLDER}"
        RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE err)
    if(NOT code STREQUAL "${expected}")
        complain("billow ${ARGN}: exit code ${code} instead of ${expected}\n${out}${err}")
    endif()
endmacro()
macro(expect_match text regex)
    if(NOT "${text}" MATCHES "${regex}")
        complain("'${text}' does not match ${regex}")
    endif()
endmacro()
macro(expect_file name)
    if(NOT EXISTS "${FOLDER}/${name}")
        complain("${name} is missing")
    endif()
endmacro()

# --- What works ---------------------------------------------------------------------------------

run(0 --version)
expect_match("${out}" "billow [0-9]+\\.[0-9]+\\.[0-9]+")
run(0 --help)
expect_match("${out}" "build.*inspect")
run(0 build --help)
foreach(option preset epsilon planes max-planes plane-space raster rho-rate refine fit skip-area
        min-contribution contribution normal-threshold penalty penalty-in-refinement falloff
        falloff-strength horizontal-penalty fly-over up distribution compact weld weld-angle
        cardboard cracks split foliage-materials trunk trunk-epsilon trunk-contribution trunk-weld
        trunk-cardboard trunk-alpha texels max-atlas supersample alpha-threshold padding
        power-of-two threads report atlas-png config quiet)
    expect_match("${out}" "--${option}")
endforeach()

run(0 build cube.glb -o cube_cloud.glb --epsilon 2% --texels 128 --report cube.json
    --atlas-png cube.png)
expect_match("${out}" "6 planes")
expect_file(cube_cloud.glb)
expect_file(cube.png)
file(READ "${FOLDER}/cube.json" report)
foreach(key faces planes triangles epsilon radius max_error mean_error max_error_over_epsilon
        projected_area_share rectangle_use mapped_faces kept_faces kept_triangles skipped_faces
        degenerate_faces faces_beyond_epsilon preset model search welding parts threads textures)
    string(JSON value ERROR_VARIABLE missing GET "${report}" ${key})
    if(missing)
        complain("the report lacks ${key}")
    endif()
endforeach()
foreach(key name planes cardboard_planes epsilon mapped_faces search options)
    string(JSON value GET "${report}" parts 0 ${key})
endforeach()
foreach(key torn_vertices moved_vertices welded_vertices largest_displacement)
    string(JSON value GET "${report}" welding ${key})
endforeach()
foreach(key width height fill)
    string(JSON value GET "${report}" atlas ${key})
endforeach()
foreach(key load search bake write total)
    string(JSON value GET "${report}" seconds ${key})
endforeach()
string(JSON planes GET "${report}" planes)
if(NOT planes EQUAL 6)
    complain("a cube has ${planes} planes")
endif()
run(0 inspect cube_cloud.glb)
expect_match("${out}" "billboard cloud: 6 planes, 12 triangles")
run(0 inspect teapot.glb)
expect_match("${out}" "faces: 552")

# Other compositions, lengths in scene units, a configuration file.
run(0 build teapot.glb -o teapot_cloud.glb --epsilon 0.2 --texels 128 --plane-space spherical
    --raster 12 --fit svd --refine original --penalty 2 --rho-rate 1 --supersample 2 --padding 4
    --max-atlas 512 --power-of-two)
run(0 build leaves.glb -o leaves_cloud.glb --texels 128 --refine none --fit average)
run(0 build leaves.glb -o leaves_minimax.glb --texels 64 --fit minimax --quiet)
run(0 --config options.toml build leaves.glb -o few.glb --texels 64 --report few.json --quiet)
expect_match("x${out}${err}x" "^xx$")
file(READ "${FOLDER}/few.json" report)
string(JSON planes GET "${report}" planes)
string(JSON epsilon GET "${report}" parts 0 options epsilon)
if(NOT planes EQUAL 3 OR NOT epsilon STREQUAL "20%")
    complain("the configuration gave ${planes} planes at ${epsilon}")
endif()
run(0 build leaves.glb -o few.glb --config options.toml --texels 64 --max-planes 2)
expect_match("${out}" "2 planes.*beyond epsilon")

# Any number of threads writes the same bytes.
foreach(threads 1 2 3 8)
    run(0 build leaves.glb -o threads_${threads}.glb --texels 128 --threads ${threads} --quiet)
    file(SHA256 "${FOLDER}/threads_${threads}.glb" hash)
    if(DEFINED first_hash AND NOT hash STREQUAL first_hash)
        complain("${threads} threads write other bytes than 1")
    endif()
    set(first_hash ${hash})
endforeach()

# No face, one face, none with an area, no material.
foreach(name "empty" "one face" "degenerate")
    run(0 build "${name}.glb" -o "${name}_cloud.glb")
    expect_file("${name}_cloud.glb")
    run(0 inspect "${name}_cloud.glb")
endforeach()
run(0 build square.obj -o square_cloud.glb --texels 64)
expect_match("${out}" "1 planes|1 plane,")

include("${CMAKE_CURRENT_LIST_DIR}/lod.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/planes.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/sweep.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/mips.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/textures.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/compare.cmake")

# --- What does not ------------------------------------------------------------------------------

file(GLOB before RELATIVE "${FOLDER}" "${FOLDER}/*")
foreach(input missing.glb nothing.glb words.glb words.xyz nan.obj draco.gltf cycle.gltf huge.gltf
        truncated.glb .)
    run(1 build ${input} -o broken.glb)
    string(REGEX REPLACE "\n$" "" line "${err}")
    string(REGEX REPLACE "^load\n" "" line "${line}")
    expect_match("${line}" "^billow: [^\n]*${input}[^\n]*$")
    run(1 inspect ${input})
endforeach()
run(1 build cube.glb -o no/such/folder/cloud.glb)
expect_match("${err}" "no/such/folder")
run(1 build cube.glb -o cloud.glb --report no/such/folder/report.json)

foreach(arguments "--epsilon;0" "--epsilon;-3%" "--epsilon;ten" "--epsilon;nan" "--epsilon;5%%"
        "--raster;17" "--raster;0" "--fit;best" "--refine;all" "--texels;0" "--texels;many"
        "--supersample;99" "--plane-space;torus" "--nonsense" "--padding;100;--max-atlas;128")
    run(2 build cube.glb -o broken.glb ${arguments})
    if(err STREQUAL "")
        complain("${arguments} is refused without a word")
    endif()
endforeach()
run(2)
run(2 build cube.glb)
run(2 build cube.glb -o cloud.obj)
run(2 build cube.glb -o cube.glb)
run(2 paint cube.glb)

# Nothing half-written is left behind.
file(GLOB after RELATIVE "${FOLDER}" "${FOLDER}/*")
if(NOT before STREQUAL after)
    complain("failures leave files behind: ${after}\nbefore: ${before}")
endif()

get_property(failures GLOBAL PROPERTY failures)
list(LENGTH failures count)
if(count GREATER 0)
    message(FATAL_ERROR "${count} failures")
endif()
