import sys
sys.argv=['w','uc4','7.5,8,7,9','0,1,2,3','800','0','40']
exec(open('wip/write.py').read())
import certificates.cells as C
from certificates.polynomials import *
from certificates.geometry import Turned
from certificates import guess
s=s2
for l in BAD[:6]:
    c=l.cell
    print('=====',[b[1]-b[0] for b in c.bounds],c.side,l.data)
    u=[between(rational(a),rational(b),k) for k,(a,b) in enumerate(c.bounds[:3])]
    T=Turned(s.platform,c.chart,u)
    x=C.on_branch(T,c.side,2)
    if x is None: print('none'); continue
    P_=C.Place(T,x); w=T.wrenches(x); rows=[[number(centre(v)) for v in q] for q in w]
    y=[float(v) for v in l.data]
    for it in range(3):
        yn=max(map(abs,y)); y=[v/yn for v in y]
        forms=[dot([constant(rational(v)) for v in y],q) for q in w]
        print('const c',[f'{number(centre(f)):.2e}' for f in forms],'fr',[f'{number(size(P_.freed(f))-abs(centre(P_.freed(f)))):.2e}' for f in forms], 'cf',[f'{number(centre(P_.freed(f))):.2e}' for f in forms])
        r=[number(centre(P_.freed(f))-lowest(P_.freed(f))) for f in forms]
        y=guess.least_norm(rows,[r])[0]
