# Figures 8 and 9 of the seed paper from the data that examples/seed_sphere.cpp writes into the folder `out`:
#   gnuplot -e "out='out'" examples/seed_sphere.gnuplot
set datafile separator ","
set terminal svg size 900,520 dynamic enhanced font "Helvetica,16" background "white"
blue = "#0072B2"; vermilion = "#D55E00"; green = "#009E73"  # told apart by the colour-blind too
purple = "#CC79A7"; sky = "#56B4E9"; orange = "#E69F00"

set border 3 linecolor "#666666"
set tics nomirror out textcolor "#333333"
set grid linecolor "#e4e4e4" linetype 1
set xlabel "time t [s]"
set xrange [0:0.6]
set xtics 0.12
set key outside right center spacing 1.35 samplen 2.5 Left reverse textcolor "#333333"
slip_ends = 0.291247997670016
set arrow 1 from slip_ends, graph 0 to slip_ends, graph 1 nohead linecolor "#999999" dashtype 3
set label 1 "slides" at slip_ends - 0.01, graph 0.96 right textcolor "#777777"
set label 2 "rolls" at slip_ends + 0.01, graph 0.96 left textcolor "#777777"
exact = "linecolor '#222222' linewidth 1.6 dashtype '..'"

set output out."/figure8.svg"
set title "Velocity of the sphere, h = 0.12 s: steps over the exact motion"
set ylabel "v [m/s],  {/Symbol w} [rad/s]"
set yrange [-0.15:2.25]
quantity = "vx wy vy vz wx wz"
name(i) = word("v_x ω_y v_y v_z ω_x ω_z", i)
colour(i) = word(blue." ".vermilion." ".green." ".orange." ".purple." ".sky, i)
mark(i) = int(word("7 4 6 8 10 12", i))
size_of(i) = word("0.7 1.3 0.6 0.9 1.2 1.6", i) + 0
plot for [i = 1:3] out."/figure8_exact.csv" using "t":word(quantity, i) with lines @exact \
       title i == 1 ? "exact" : "", \
     for [i = 1:6] out."/figure8.csv" using "t":word(quantity, i) with points \
       pointtype mark(i) pointsize size_of(i) linewidth 1.8 linecolor rgb colour(i) title name(i)

set output out."/figure9.svg"
set title "Force on the sphere, h = 0.12 s: tangent axes turned by π/4"
set ylabel "force [N]"
set yrange [-2.5:11]
set ytics 2
quantity = "ct co cn"
name(i) = word("c_t c_o c_n", i)
colour(i) = word(blue." ".vermilion." ".green, i)
plot for [i = 1:3] out."/figure9.csv" using "t":word(quantity, i) with lines \
       linewidth 3 linecolor rgb colour(i) title name(i), \
     for [i = 1:3] out."/figure9_exact.csv" using "t":word(quantity, i) with lines @exact \
       title i == 1 ? "exact" : ""
